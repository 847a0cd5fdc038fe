// Files as bytes: reading each once, provenance. Writing: output_files.h.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace sagitta {

// One run of a command. While it lives, what this thread reads through ReadTextFile is read once, so that what is
// recognised, hashed and parsed are the same bytes (and pipes can be read at all); and no output may be one of the
// inputs. Within another session it does nothing: that one goes on.
class FileSession {
 public:
  FileSession();
  ~FileSession();
  FileSession(const FileSession&) = delete;
  FileSession& operator=(const FileSession&) = delete;

 private:
  bool is_outermost_;
};

// The rule for inputs and outputs, in one place: says that the session will write `path`. Throws InputError where that
// is a file the session reads, before or after, by whatever name or link, or another output.
void DeclareOutput(const std::string& path);

// The same rule where no session read the inputs: throws InputError where one of `names` in the folder is one of them.
void CheckInputsAreKept(const std::vector<std::string>& inputs, const std::string& folder,
                        const std::vector<std::string>& names);

// At most limits::kFileBytes. Throws InputError when the file is absent, longer, or cannot be read.
std::string ReadTextFile(const std::string& path);
// The same without a copy of what the session keeps: a table may be long.
std::shared_ptr<const std::string> SharedText(const std::string& path);

// Nobody reads it again: the session keeps that it is an input, not what may be long.
void ForgetText(const std::string& path);

// The same, of a file that is the session's own and may change: neither remembered nor an input.
std::string ReadOwnFile(const std::string& path);

// The line of the first byte that is no UTF-8; 0: all is.
int LineOfInvalidUtf8(const std::string& bytes);

// Lower-case hexadecimal digest.
std::string Sha256(const std::string& bytes);
// Its first sixteen letters as a number: in the order of the texts.
std::uint64_t StartOfSha256(const std::string& bytes);

}  // namespace sagitta
