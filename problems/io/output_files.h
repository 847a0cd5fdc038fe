// Writing that is whole or not at all, one file or a set of them.
//
// Everything is written to new files with random names in the target's folder (never through a link), flushed to disk,
// and only then put in place by renaming. A set of several files notes what is to be renamed before the first rename:
// if the run ends in between, whoever reads from or writes to the folder next finishes it. Files that are replaced
// keep their permissions.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace sagitta {

using NamedText = std::pair<std::string, std::string>;  // file name, text

// A text too long to be held: hands it on piece by piece.
using TextSink = std::function<void(const std::string& piece)>;
struct LongText {
  std::string name;  // of the file
  std::function<void(const TextSink& write)> text;
};

// Throws InputError; then the file is as it was.
void WriteTextFile(const std::string& path, const std::string& text);

// Folders on the way to an output, made where they are absent and removed again if they stay empty.
class NewFolders {
 public:
  explicit NewFolders(const std::string& folder);  // throws InputError
  ~NewFolders();
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;

 private:
  std::vector<std::string> made_;  // outermost first
};

// One file, with the folder it is to be in. Throws InputError at once where it cannot be written or is an input of the
// session (DeclareOutput).
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  // Throws Interruption where the work was interrupted; then the file is as it was.
  void Write(const std::string& text) const;
  // Those of one run, in whatever folders: all new ones are on disk before the first is put in place.
  static void WriteTogether(const std::vector<std::pair<const OutputFile*, std::string>>& files);

 private:
  std::string path_;
  NewFolders folders_;
};

// A set of files in one folder, which no other run writes to while this lives. Throws InputError at once where the
// folder cannot be written, another run has it, or one of the names is an input of the session.
class OutputFolder {
 public:
  OutputFolder(const std::string& path, const std::vector<std::string>& names);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::string& path() const { return path_; }
  // All files or none; none, and an Interruption, where the work was interrupted.
  void Write(const std::vector<NamedText>& files, const std::vector<LongText>& long_files = {}) const;

 private:
  std::string path_;
  NewFolders folders_;
  int descriptor_ = -1;
};

// Puts in place what a run had noted down when it ended; nothing where no run did. "": the working folder. Throws
// InputError where that is not possible.
void FinishInterruptedWrite(const std::string& folder);

}  // namespace sagitta
