// Progress lines on stderr, twice a second at most: from the start on a terminal, elsewhere only when the work needs
// longer than a second. They say which phase of how many it is, and about how long the rest will need. Work that
// reports its progress is interrupted there, and how far it was is said.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sagitta {

struct ProgressPhase {
  std::string begins;  // how what is said of it begins
  double share;        // of the time that all phases need; only their ratios count
};

// What was said, in words with phase and time left. What fits the beginning of no later phase belongs to the present
// one.
class ProgressMeter {
 public:
  explicit ProgressMeter(std::vector<ProgressPhase> phases);

  // "12 of 400" in the words is how far the phase is. seconds: since the start.
  void Say(const std::string& what, double seconds);
  // "phase 2 of 5: solving (about 20 s left)"; empty: nothing was said yet.
  std::string Line(double seconds) const;

 private:
  double ShareDone(double of_phase) const;
  double Expected(double seconds) const;

  std::vector<ProgressPhase> phases_;
  int phase_ = -1;
  std::string what_;
  double expected_ = 0.0;  // s, all together; 0: not known yet
};

class Progress {
 public:
  // No phases: what is said stands alone.
  explicit Progress(bool quiet, std::vector<ProgressPhase> phases = {});
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Throws Interruption where the work of this thread was interrupted.
  void Say(const std::string& what);

 private:
  double Seconds() const;
  void PrintUntilDone();

  const bool quiet_;
  bool done_ = false, has_news_ = false;
  ProgressMeter meter_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::condition_variable ended_;
  std::thread printer_;
};

// Runs `work`; where it is interrupted, says on stderr what `found` knows so far (lines, or nothing), and lets the
// interruption go on.
void SayingWhatWasFound(const std::function<void()>& work, const std::function<std::string()>& found);

}  // namespace sagitta
