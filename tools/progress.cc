#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <utility>

#include "problems/interruption.h"
#include "problems/io/pattern.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

constexpr double kTooEarly = 0.05;    // share of the work: what it needed says little of the rest, unless it is counted
constexpr double kWorthSaying = 2.0;  // s
constexpr double kSilence = 10.0;     // s, after which the same is said again

std::string InWords(double seconds) {
  if (seconds < 90.0) return std::to_string(std::lround(seconds)) + " s";
  return std::to_string(std::lround(seconds / 60.0)) + " min";
}

// "bootstrap: 12 of 400": 0.03; nothing of the kind: 0.
double ShareIn(const std::string& what) {
  static const std::regex kCount = MakePattern("([0-9]+) of ([0-9]+)");
  std::smatch found;
  if (!SearchPattern(what, &found, kCount)) return 0.0;
  const double all = ParseNumber(found[2].str()).value();
  return all > 0.0 ? std::min(1.0, ParseNumber(found[1].str()).value() / all) : 0.0;
}

}  // namespace

ProgressMeter::ProgressMeter(std::vector<ProgressPhase> phases) : phases_(std::move(phases)) {}

double ProgressMeter::ShareDone(double of_phase) const {
  double before = 0.0, all = 0.0;
  for (int i = 0; i < static_cast<int>(phases_.size()); ++i) {
    all += phases_[i].share;
    if (i < phase_) before += phases_[i].share;
    if (i == phase_) before += of_phase * phases_[i].share;
  }
  return all > 0.0 ? before / all : of_phase;
}

void ProgressMeter::Say(const std::string& what, double seconds) {
  const auto first = phases_.begin() + std::max(0, phase_);
  const int before = phase_;
  const auto own =
      std::find_if(first, phases_.end(), [&](const ProgressPhase& phase) { return what.rfind(phase.begins, 0) == 0; });
  if (own != phases_.end()) phase_ = static_cast<int>(own - phases_.begin());
  what_ = what;
  const double share = ShareIn(what);
  const double done = ShareDone(share);
  // Within a phase that does not say how far it is, what was expected at its beginning stands.
  if ((phase_ != before || share > 0.0) && (done >= kTooEarly || (share > 0.0 && seconds >= kWorthSaying)))
    expected_ = seconds / done;
}

// s, all together. A phase that needs longer than its share makes what follows longer in proportion, even if it ended
// now.
double ProgressMeter::Expected(double seconds) const {
  if (expected_ == 0.0 || phase_ < 0 || ShareIn(what_) > 0.0) return expected_;
  return std::max(expected_, seconds / ShareDone(1.0));
}

std::string ProgressMeter::Line(double seconds) const {
  if (what_.empty()) return "";
  std::string line = what_;
  if (phase_ >= 0)
    line = "phase " + std::to_string(phase_ + 1) + " of " + std::to_string(phases_.size()) + ": " + what_;
  const double left = Expected(seconds) - seconds;
  if (left >= kWorthSaying) return line + " (about " + InWords(left) + " left)";
  return seconds >= kWorthSaying ? line + " (" + InWords(seconds) + " so far)" : line + " ...";
}

Progress::Progress(bool quiet, std::vector<ProgressPhase> phases) : quiet_(quiet), meter_(std::move(phases)) {
  if (!quiet) printer_ = std::thread(&Progress::PrintUntilDone, this);
}

Progress::~Progress() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = true;
  }
  ended_.notify_all();
  if (printer_.joinable()) printer_.join();
  const std::string line = meter_.Line(Seconds());
  if (IsInterrupted() && !quiet_ && !line.empty()) std::cerr << "sagitta: it was at " << line << "\n";
}

double Progress::Seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::Say(const std::string& what) {
  CheckInterruption();
  const std::lock_guard<std::mutex> lock(mutex_);
  meter_.Say(what, Seconds());
  has_news_ = true;
}

void Progress::PrintUntilDone() {
  std::unique_lock<std::mutex> lock(mutex_);
  std::chrono::milliseconds wait(isatty(STDERR_FILENO) != 0 ? 50 : 1000);
  double printed = 0.0;
  while (!ended_.wait_for(lock, wait, [this] { return done_; })) {
    const double now = Seconds();
    const std::string line = meter_.Line(now);
    if (!line.empty() && (has_news_ || now - printed >= kSilence)) {
      std::cerr << "sagitta: " << line << std::endl;
      printed = now;
      has_news_ = false;
    }
    wait = std::chrono::milliseconds(500);
  }
}

void SayingWhatWasFound(const std::function<void()>& work, const std::function<std::string()>& found) {
  try {
    work();
    CheckInterruption();
  } catch (const Interruption&) {
    const std::string words = found();
    std::cerr << (words.empty() ? "sagitta: nothing was found so far\n" : "sagitta: found so far:\n" + words);
    throw;
  }
}

}  // namespace sagitta
