#include "tools/terminal.h"

#include "problems/io/text_checks.h"

namespace sagitta {

PrintableStream::PrintableStream(std::ostream* stream) : stream_(stream), target_(stream->rdbuf(this)) {}

PrintableStream::~PrintableStream() {
  PrintableStream::sync();
  stream_->rdbuf(target_);
}

bool PrintableStream::PassOn(size_t count) {
  const std::string text = Printable(std::string_view(pending_).substr(0, count), true);
  pending_.erase(0, count);
  return target_->sputn(text.data(), static_cast<std::streamsize>(text.size())) ==
         static_cast<std::streamsize>(text.size());
}

PrintableStream::int_type PrintableStream::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  const char character = traits_type::to_char_type(c);
  return xsputn(&character, 1) == 1 ? c : traits_type::eof();
}

std::streamsize PrintableStream::xsputn(const char* text, std::streamsize count) {
  const std::lock_guard<std::mutex> lock(mutex_);
  pending_.append(text, static_cast<size_t>(count));
  const size_t line_end = pending_.rfind('\n');  // whole lines: no character is cut
  return line_end == std::string::npos || PassOn(line_end + 1) ? count : 0;
}

int PrintableStream::sync() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool passed_on = PassOn(pending_.size());
  return target_->pubsync() == 0 && passed_on ? 0 : -1;
}

}  // namespace sagitta
