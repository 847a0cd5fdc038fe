#include <iconv.h>

#include <cerrno>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/import/text_table.h"

namespace sagitta {
namespace {

std::string Converted(const std::string& bytes, const char* encoding, const std::string& path) {
  const iconv_t conversion = iconv_open("UTF-8", encoding);
  if (conversion == reinterpret_cast<iconv_t>(-1)) {  // NOLINT(performance-no-int-to-ptr): as POSIX says it
    throw InputError({path, 0, ""}, std::string("this system cannot convert ") + encoding, "save the file as UTF-8");
  }
  std::string text(4 * bytes.size() + 16, '\0');  // no character of these encodings needs more
  char* from = const_cast<char*>(bytes.data());
  char* to = text.data();
  size_t from_left = bytes.size(), to_left = text.size();
  const size_t result = iconv(conversion, &from, &from_left, &to, &to_left);
  iconv_close(conversion);
  if (result == static_cast<size_t>(-1)) {
    throw InputError({path, 0, ""}, std::string("this is not text in ") + encoding, "save the file as UTF-8");
  }
  text.resize(text.size() - to_left);
  return text;
}

bool StartsWith(const std::string& bytes, const char* start, size_t length) {
  return bytes.compare(0, length, start, length) == 0;
}

// In UTF-16 text of digits and Latin letters every other byte is 0. The parity of the zero bytes, -1: none.
int ParityOfZeros(const std::string& bytes) {
  size_t zeros[2] = {0, 0};
  for (size_t i = 0; i < bytes.size(); ++i) zeros[i % 2] += bytes[i] == '\0';
  // Of UTF-16 in Latin letters one half is zeros, every second byte; with other letters among them a third at least.
  for (const int parity : {0, 1}) {
    if (3 * zeros[parity] > bytes.size() && 20 * zeros[1 - parity] < bytes.size()) return parity;
  }
  return -1;
}

}  // namespace

std::string DecodeText(const std::string& bytes, const std::string& path, std::string* encoding) {
  if (StartsWith(bytes, "PK\x03\x04", 4) || StartsWith(bytes, "\xD0\xCF\x11\xE0", 4)) {
    throw InputError({path, 0, ""}, "this is a workbook",
                     "save the sheet as CSV or text; any separator and decimal sign will do");
  }
  *encoding = "UTF-8";
  if (StartsWith(bytes, "\xEF\xBB\xBF", 3)) return bytes.substr(3);
  if (StartsWith(bytes, "\xFF\xFE", 2) || StartsWith(bytes, "\xFE\xFF", 2)) {
    *encoding = "UTF-16";
    return Converted(bytes.substr(2), bytes[0] == '\xFF' ? "UTF-16LE" : "UTF-16BE", path);
  }
  const int parity = ParityOfZeros(bytes);
  if (parity >= 0) {
    *encoding = "UTF-16 without BOM";
    return Converted(bytes, parity == 1 ? "UTF-16LE" : "UTF-16BE", path);
  }
  if (bytes.find('\0') != std::string::npos) throw InputError({path, 0, ""}, "this is not a text file");
  if (LineOfInvalidUtf8(bytes) == 0) return bytes;
  *encoding = "Windows-1252 (it is not UTF-8)";
  return Converted(bytes, "WINDOWS-1252", path);
}

}  // namespace sagitta
