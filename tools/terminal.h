// What goes to the terminal: text, whatever the names in the files hold.
#pragma once

#include <iostream>
#include <mutex>
#include <streambuf>
#include <string>

namespace sagitta {

// While it lives, what is written to the stream comes out with control characters as \x1b, line ends and tabs aside.
class PrintableStream : public std::streambuf {
 public:
  explicit PrintableStream(std::ostream* stream);
  ~PrintableStream() override;
  PrintableStream(const PrintableStream&) = delete;
  PrintableStream& operator=(const PrintableStream&) = delete;

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;

 private:
  bool PassOn(size_t count);  // of pending_

  std::ostream* stream_;
  std::streambuf* target_;
  std::string pending_;
  std::mutex mutex_;  // progress is written by a thread of its own
};

}  // namespace sagitta
