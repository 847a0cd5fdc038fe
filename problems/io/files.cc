#include "problems/io/files.h"

#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include "problems/input_error.h"

namespace sagitta {
namespace {

namespace fs = std::filesystem;

// A name next to `path` that no other process uses.
std::string TemporaryName(const std::string& path) { return path + ".tmp" + std::to_string(getpid()); }

// "" when all was written, else the reason.
std::string TryWrite(const std::string& path, const std::string& text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (file) return "";
  return errno != 0 ? std::strerror(errno) : "the file could not be written";
}

void RemoveQuietly(const fs::path& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

// The folders on the way to `path` that do not exist, outermost first.
std::vector<fs::path> AbsentFolders(const fs::path& path) {
  std::vector<fs::path> absent;
  std::error_code ignored;
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, ignored); folder = folder.parent_path()) {
    absent.insert(absent.begin(), folder);
    if (folder == folder.parent_path()) break;
  }
  return absent;
}

void RemoveInnermostFirst(const std::vector<fs::path>& folders) {
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) RemoveQuietly(*folder);
}

// Of the UTF-8 character at i (RFC 3629); 0: there is none.
size_t CharacterLength(const std::string& bytes, size_t i) {
  const auto byte = [&](size_t k) { return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u; };
  const unsigned first = byte(i);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
  }
  const unsigned second = byte(i + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool no_character = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || no_character ? 0 : length;
}

}  // namespace

std::string ReadTextFile(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError({path, 0, ""}, "there is no such file");
  if (fs::is_directory(status)) throw InputError({path, 0, ""}, "this is a folder, a file is expected");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  // Inserting an empty buffer sets failbit, which is no failure here.
  if (file && file.peek() != std::ifstream::traits_type::eof()) bytes << file.rdbuf();
  if (!file.is_open() || file.bad() || bytes.bad()) {
    throw InputError({path, 0, ""}, "the file cannot be read: " + std::string(std::strerror(errno)));
  }
  return bytes.str();
}

void WriteTextFile(const std::string& path, const std::string& text) {
  const std::string temporary = TemporaryName(path);
  const std::string reason = TryWrite(temporary, text);
  if (!reason.empty()) {
    RemoveQuietly(temporary);
    throw InputError({path, 0, ""}, "the file cannot be written: " + reason);
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (!error) return;
  RemoveQuietly(temporary);
  throw InputError({path, 0, ""}, "the file cannot be written: " + error.message());
}

void PrepareOutputFolder(const std::string& path) {
  if (path.empty()) throw InputError({"", 0, "out"}, "the output folder has no name");
  // Without a trailing slash, so that parent_path() goes up one folder.
  fs::path folder = fs::path(path).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw InputError({path, 0, ""}, "this is a file, an output folder is expected");
  }
  const std::vector<fs::path> absent = AbsentFolders(folder);
  fs::create_directories(folder, error);
  if (error) {
    RemoveInnermostFirst(absent);
    throw InputError({path, 0, ""}, "the output folder cannot be made: " + error.message());
  }
  const std::string probe = TemporaryName((folder / "sagitta").string());
  const std::string reason = TryWrite(probe, "");
  RemoveQuietly(probe);
  if (reason.empty()) return;
  RemoveInnermostFirst(absent);
  throw InputError({path, 0, ""}, "the output folder cannot be written: " + reason);
}

int LineOfInvalidUtf8(const std::string& bytes) {
  int line = 1;
  for (size_t i = 0; i < bytes.size();) {
    const size_t length = CharacterLength(bytes, i);
    if (length == 0) return line;
    line += bytes[i] == '\n';
    i += length;
  }
  return 0;
}

std::string Sha256(const std::string& bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  }
  constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kHex[digest[i] >> 4];
    text += kHex[digest[i] & 15];
  }
  return text;
}

std::string FormatNumber(double value) {
  char buffer[64];
  const std::to_chars_result result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, result.ptr);
}

}  // namespace sagitta
