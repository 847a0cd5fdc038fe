#include "problems/io/files.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>
#include <vector>

#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

namespace fs = std::filesystem;

struct Identity {
  std::string path;  // as given
  fs::path canonical;
  dev_t device = 0;
  ino_t inode = 0;
  bool exists = false;

  bool IsSameAs(const Identity& other) const {
    if (exists && other.exists) return device == other.device && inode == other.inode;
    return !canonical.empty() && canonical == other.canonical;
  }
};

Identity IdentityOf(const std::string& path) {
  Identity identity{path, {}};
  std::error_code ignored;
  identity.canonical = fs::weakly_canonical(path, ignored);
  struct stat status;
  identity.exists = stat(path.c_str(), &status) == 0;
  if (identity.exists) identity.device = status.st_dev, identity.inode = status.st_ino;
  return identity;
}

struct Session {
  std::map<std::string, std::shared_ptr<const std::string>> texts;  // by path
  std::vector<Identity> inputs, outputs;
};

thread_local std::unique_ptr<Session> session;

constexpr char kOtherOut[] = "give another --out";

[[noreturn]] void FailInputIsOutput(const Identity& input, const Identity& output, const char* hint) {
  throw InputError({input.path, 0, ""},
                   "this input would be overwritten by the output '" + output.path + "'; nothing is written", hint);
}

// All bytes from where the descriptor is; a device that never ends is cut off by the limit.
std::string ReadAll(int descriptor, const std::string& path) {
  std::string bytes;
  struct stat status;
  if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0) {
    bytes.reserve(std::min(static_cast<size_t>(status.st_size), limits::kFileBytes));
  }
  std::vector<char> block(1 << 20);
  while (true) {
    const ssize_t count = read(descriptor, block.data(), block.size());
    if (count == 0) return bytes;
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw InputError({path, 0, ""}, "the file cannot be read: " + std::string(std::strerror(errno)));
    if (bytes.size() + static_cast<size_t>(count) > limits::kFileBytes) {
      throw InputError({path, 0, ""}, "the file is longer than " + std::to_string(limits::kFileBytes >> 20) + " MB",
                       "split it, or leave out columns that nothing needs");
    }
    bytes.append(block.data(), static_cast<size_t>(count));
  }
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

FileSession::FileSession() : is_outermost_(session == nullptr) {
  if (is_outermost_) session = std::make_unique<Session>();
}

FileSession::~FileSession() {
  if (is_outermost_) session.reset();
}

void DeclareOutput(const std::string& path) {
  if (session == nullptr) return;
  const Identity output = IdentityOf(path);
  for (const Identity& input : session->inputs) {
    if (input.IsSameAs(output)) FailInputIsOutput(input, output, kOtherOut);
  }
  for (const Identity& other : session->outputs) {
    if (other.IsSameAs(output))
      throw InputError({path, 0, ""}, "two outputs would be written to this file; nothing is written", kOtherOut);
  }
  session->outputs.push_back(output);
}

void CheckInputsAreKept(const std::vector<std::string>& inputs, const std::string& folder,
                        const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const Identity output = IdentityOf((fs::path(folder) / name).string());
    for (const std::string& path : inputs) {
      const Identity input = IdentityOf(path);
      if (input.IsSameAs(output)) FailInputIsOutput(input, output, "give another folder");
    }
  }
}

std::string ReadOwnFile(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError({path, 0, ""}, "there is no such file");
  if (fs::is_directory(status)) throw InputError({path, 0, ""}, "this is a folder, a file is expected");
  FinishInterruptedWrite(fs::path(path).parent_path().string());
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0) throw InputError({path, 0, ""}, "the file cannot be read: " + std::string(std::strerror(errno)));
  const std::unique_ptr<const int, void (*)(const int*)> closer(&descriptor, [](const int* d) { close(*d); });
  return ReadAll(descriptor, path);
}

std::shared_ptr<const std::string> SharedText(const std::string& path) {
  if (session == nullptr) return std::make_shared<const std::string>(ReadOwnFile(path));
  const auto known = session->texts.find(path);
  if (known != session->texts.end()) return known->second;
  const Identity input = IdentityOf(path);
  for (const Identity& output : session->outputs) {
    if (input.IsSameAs(output)) FailInputIsOutput(input, output, kOtherOut);
  }
  const auto text = std::make_shared<const std::string>(ReadOwnFile(path));
  session->inputs.push_back(input);
  return session->texts[path] = text;
}

std::string ReadTextFile(const std::string& path) { return *SharedText(path); }

void ForgetText(const std::string& path) {
  if (session != nullptr) session->texts.erase(path);
}

int LineOfInvalidUtf8(const std::string& bytes) {
  unsigned char all = 0;
  for (const char c : bytes) all |= static_cast<unsigned char>(c);
  if (all < 0x80) return 0;  // ASCII, as most files are
  int line = 1;
  for (size_t i = 0; i < bytes.size();) {
    if (static_cast<unsigned char>(bytes[i]) < 0x80) {
      line += bytes[i++] == '\n';
      continue;
    }
    const size_t length = CharacterLength(bytes, i);
    if (length == 0) return line;
    i += length;
  }
  return 0;
}

namespace {

using Digest = std::array<unsigned char, EVP_MAX_MD_SIZE>;

// Returns how many bytes of it there are.
unsigned int DigestOf(const std::string& bytes, Digest* digest) {
  // Looked up once: names of configurations are hashed by the ten thousand.
  static const EVP_MD* const kSha256 = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  unsigned int size = 0;
  if (kSha256 == nullptr || EVP_Digest(bytes.data(), bytes.size(), digest->data(), &size, kSha256, nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  }
  return size;
}

}  // namespace

std::uint64_t StartOfSha256(const std::string& bytes) {
  Digest digest;
  DigestOf(bytes, &digest);
  std::uint64_t start = 0;
  for (size_t i = 0; i < sizeof(start); ++i) start = start << 8 | digest[i];
  return start;
}

std::string Sha256(const std::string& bytes) {
  Digest digest;
  const unsigned int size = DigestOf(bytes, &digest);
  constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * size);
  for (unsigned int i = 0; i < size; ++i) {
    text += kHex[digest[i] >> 4];
    text += kHex[digest[i] & 15];
  }
  return text;
}

}  // namespace sagitta
