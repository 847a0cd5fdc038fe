#include "problems/io/output_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <system_error>
#include <utility>

#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/io/files.h"

namespace sagitta {
namespace {

namespace fs = std::filesystem;

// Names of ours that are no results: .sagitta-0123456789abcdef.
const std::string kTemporary = ".sagitta-";
const std::string kNote = ".sagitta-to-rename";  // what to rename once it is there
const std::string kOfOneFile = ".sagitta-one-";  // the folder is not locked, but each of these files is

[[noreturn]] void FailToWrite(const std::string& path, const std::string& reason) {
  throw InputError({path, 0, ""}, "the file cannot be written: " + reason);
}

std::string LastError() { return std::strerror(errno); }

std::string PathIn(const std::string& folder, const std::string& name) {
  return folder.empty() ? name : (fs::path(folder) / name).string();
}

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) close(value_);
  }
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int value() const { return value_; }

 private:
  int value_;
};

int OpenFolder(const std::string& folder) {
  return open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

// Nobody can have prepared a file or a link of such a name.
std::string RandomName(const std::string& start) {
  unsigned char bytes[8];
  if (getrandom(bytes, sizeof bytes, 0) != sizeof bytes) FailToWrite("", "no random numbers: " + LastError());
  std::string name = start;
  for (const unsigned char byte : bytes) {
    name += "0123456789abcdef"[byte >> 4];
    name += "0123456789abcdef"[byte & 15];
  }
  return name;
}

mode_t NewFileMode() {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

// Of what is to be replaced: only regular files, or links, which are replaced and not followed.
void TakeOver(int folder, const std::string& name, int file, const std::string& path) {
  struct stat there;
  if (fstatat(folder, name.c_str(), &there, 0) == 0) {
    if (S_ISDIR(there.st_mode)) FailToWrite(path, "this is a folder");
    if (!S_ISREG(there.st_mode)) FailToWrite(path, "this is a device or a pipe, results go to regular files");
    if (fstatat(folder, name.c_str(), &there, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(there.st_mode)) {
      if (fchown(file, there.st_uid, there.st_gid) != 0) errno = 0;  // only root may: the permissions count
      if (fchmod(file, there.st_mode & 07777) != 0) FailToWrite(path, LastError());
      return;
    }
  }
  if (fchmod(file, NewFileMode()) != 0) FailToWrite(path, LastError());
}

void WritePiece(int file, const std::string& text, const std::string& path) {
  for (size_t done = 0; done < text.size();) {
    const ssize_t count = write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) FailToWrite(path, LastError());
    done += static_cast<size_t>(count);
  }
}

void WriteAll(int file, const LongText& text, const std::string& path) {
  bool any = false;
  text.text([&](const std::string& piece) {
    any |= !piece.empty();
    WritePiece(file, piece, path);
  });
  if (any && fsync(file) != 0) FailToWrite(path, LastError());
}

LongText InOnePiece(const std::string& name, const std::string& text) {
  return {name, [&text](const TextSink& write) { write(text); }};
}

// A new file that is locked while the run lives, so that others distinguish it from what a killed run has left. One of
// them may have come between opening and locking and swept it away: then another name.
Descriptor NewLockedFile(int folder, const std::string& start, std::string* name) {
  while (true) {
    *name = RandomName(start);
    Descriptor file(openat(folder, name->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
    if (file.value() < 0) return file;
    while (flock(file.value(), LOCK_EX) != 0 && errno == EINTR) {
    }
    struct stat status;
    if (fstat(file.value(), &status) != 0 || status.st_nlink > 0) return file;
  }
}

// Temporary files that are removed again unless they were renamed.
class Temporaries {
 public:
  Temporaries(int folder, std::string path) : folder_(folder), path_(std::move(path)) {}
  ~Temporaries() {
    for (const NamedText& entry : to_rename_) unlinkat(folder_, entry.first.c_str(), 0);
  }
  Temporaries(const Temporaries&) = delete;
  Temporaries& operator=(const Temporaries&) = delete;

  void Add(const std::string& start, const LongText& text) {
    const std::string& name = text.name;
    const std::string path = PathIn(path_, name);
    std::string temporary;
    Descriptor file = NewLockedFile(folder_, start, &temporary);
    if (file.value() < 0) FailToWrite(path, LastError());
    to_rename_.emplace_back(temporary, name);
    TakeOver(folder_, name, file.value(), path);
    WriteAll(file.value(), text, path);
    locked_.push_back(std::move(file));
  }

  // Proves that a file of that name could be written; removed with the rest.
  void Probe(const std::string& start, const std::string& name) { Add(start, InOnePiece(name, "")); }

  void Rename() {
    while (!to_rename_.empty()) {
      const auto& [temporary, name] = to_rename_.front();
      if (renameat(folder_, temporary.c_str(), folder_, name.c_str()) != 0)
        FailToWrite(PathIn(path_, name), LastError());
      to_rename_.erase(to_rename_.begin());
    }
    fsync(folder_);  // where the file system has no such thing for folders, nothing more can be done
  }

  std::string Note() const {
    std::string note;
    for (const auto& [temporary, name] : to_rename_) note += temporary + " " + name + "\n";
    return note;
  }
  // They are named in a note that is on disk: whoever finds it goes on.
  void Keep() { to_rename_.clear(); }

 private:
  int folder_;
  std::string path_;
  std::vector<NamedText> to_rename_;  // temporary, name
  std::vector<Descriptor> locked_;
};

// Ctrl-C waits for these few milliseconds.
class DeferredSignals {
 public:
  DeferredSignals() {
    sigset_t deferred;
    sigemptyset(&deferred);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&deferred, signal);
    pthread_sigmask(SIG_BLOCK, &deferred, &before_);
  }
  ~DeferredSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  DeferredSignals(const DeferredSignals&) = delete;
  DeferredSignals& operator=(const DeferredSignals&) = delete;

 private:
  sigset_t before_;
};

std::string ReadNote(int folder) {
  const Descriptor note(openat(folder, kNote.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  std::string text;
  char block[4096];
  ssize_t count;
  while (note.value() >= 0 && (count = read(note.value(), block, sizeof block)) > 0) text.append(block, count);
  return text;
}

bool HasNote(int folder) {
  struct stat status;
  return fstatat(folder, kNote.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
}

// A rename that was done before is done: its temporary file is gone.
void FinishNote(int folder, const std::string& path) {
  std::istringstream lines(ReadNote(folder));
  for (std::string temporary, name; lines >> temporary && std::getline(lines >> std::ws, name);) {
    const bool is_ours = temporary.rfind(kTemporary, 0) == 0 && (temporary + name).find('/') == std::string::npos;
    if (!is_ours) FailToWrite(PathIn(path, kNote), "this is no note of ours; remove it");
    if (renameat(folder, temporary.c_str(), folder, name.c_str()) != 0 && errno != ENOENT) {
      FailToWrite(PathIn(path, name), LastError());
    }
  }
  fsync(folder);
  if (unlinkat(folder, kNote.c_str(), 0) != 0 && errno != ENOENT) FailToWrite(PathIn(path, kNote), LastError());
}

// The lock is kept until the file is gone: its run would see that it went (NewLockedFile).
void RemoveUnlessLocked(int folder, const std::string& name) {
  const Descriptor file(openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file.value() >= 0 && flock(file.value(), LOCK_EX | LOCK_NB) == 0) unlinkat(folder, name.c_str(), 0);
}

// What runs that were killed have left. `all`: the folder is locked, so nobody writes a set.
void SweepTemporaries(int opened, const std::string& folder, bool all) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(kTemporary, 0) != 0 || name == kNote) continue;
    if (name.rfind(kOfOneFile, 0) == 0) {
      RemoveUnlessLocked(opened, name);
    } else if (all) {
      unlinkat(opened, name.c_str(), 0);
    }
  }
}

void CommitOne(int folder, const std::string& path, const LongText& text) {
  const DeferredSignals deferred;
  Temporaries temporaries(folder, path);
  temporaries.Add(kOfOneFile, text);
  temporaries.Rename();
}

// Without a trailing slash, so that parent_path() goes up one folder.
fs::path FolderOf(const std::string& path) {
  fs::path folder = fs::path(path).lexically_normal();
  return folder.has_filename() ? folder : folder.parent_path();
}

}  // namespace

void WriteTextFile(const std::string& path, const std::string& text) {
  const std::string name = fs::path(path).filename().string(), folder_path = fs::path(path).parent_path().string();
  if (name.empty()) FailToWrite(path, "this is a folder");
  const Descriptor folder(OpenFolder(folder_path));
  if (folder.value() < 0) FailToWrite(path, LastError());
  CommitOne(folder.value(), folder_path, InOnePiece(name, text));
}

NewFolders::NewFolders(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> absent;  // innermost first
  for (fs::path path = FolderOf(folder); !path.empty() && !fs::exists(path, error); path = path.parent_path()) {
    absent.push_back(path.string());
    if (path == path.parent_path()) break;
  }
  for (auto path = absent.rbegin(); path != absent.rend(); ++path) {
    const bool is_new = fs::create_directory(*path, error);
    if (is_new) made_.push_back(*path);
    if (!error) continue;
    const std::string reason = error.message();
    for (auto made = made_.rbegin(); made != made_.rend(); ++made) fs::remove(*made, error);
    throw InputError({folder, 0, ""}, "the output folder cannot be made: " + reason);
  }
}

NewFolders::~NewFolders() {
  std::error_code not_empty;
  for (auto path = made_.rbegin(); path != made_.rend(); ++path) fs::remove(*path, not_empty);
}

OutputFile::OutputFile(const std::string& path) : path_(path), folders_(fs::path(path).parent_path().string()) {
  const std::string folder = fs::path(path).parent_path().string();
  if (fs::path(path).filename().empty() || fs::is_directory(path)) {
    throw InputError({path, 0, ""}, "this is a folder, an output file is expected");
  }
  const Descriptor opened(OpenFolder(folder));
  if (opened.value() < 0) FailToWrite(path, LastError());
  DeclareOutput(path);
  SweepTemporaries(opened.value(), folder, false);
  Temporaries(opened.value(), folder).Probe(kOfOneFile, fs::path(path).filename().string());
}

void OutputFile::Write(const std::string& text) const {
  CheckInterruption();
  WriteTextFile(path_, text);
}

void OutputFile::WriteTogether(const std::vector<std::pair<const OutputFile*, std::string>>& files) {
  CheckInterruption();
  const DeferredSignals deferred;
  std::vector<Descriptor> folders;
  std::vector<std::unique_ptr<Temporaries>> written;
  for (const auto& [file, text] : files) {
    const fs::path path = file->path_;
    folders.emplace_back(OpenFolder(path.parent_path().string()));
    if (folders.back().value() < 0) FailToWrite(file->path_, LastError());
    written.push_back(std::make_unique<Temporaries>(folders.back().value(), path.parent_path().string()));
    written.back()->Add(kOfOneFile, InOnePiece(path.filename().string(), text));
  }
  for (const auto& one : written) one->Rename();
}

OutputFolder::OutputFolder(const std::string& path, const std::vector<std::string>& names)
    : path_(path.empty() ? throw InputError({"", 0, "out"}, "the output folder has no name") : path), folders_(path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) throw InputError({path, 0, ""}, "this is a file, an output folder is expected");
  Descriptor folder(OpenFolder(path));
  if (folder.value() < 0) throw InputError({path, 0, ""}, "the output folder cannot be read: " + LastError());
  // Where the file system knows no locks there is none.
  if (flock(folder.value(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw InputError({path, 0, ""}, "another run is writing to this folder", "wait for it, or give another --out");
  }
  if (HasNote(folder.value())) FinishNote(folder.value(), path);
  SweepTemporaries(folder.value(), path, true);
  Temporaries probes(folder.value(), path);
  for (const std::string& name : names) {
    DeclareOutput(PathIn(path, name));
    probes.Probe(kTemporary, name);
  }
  descriptor_ = fcntl(folder.value(), F_DUPFD_CLOEXEC, 0);
  if (descriptor_ < 0) throw InputError({path, 0, ""}, "the output folder cannot be opened: " + LastError());
}

OutputFolder::~OutputFolder() {
  if (descriptor_ >= 0) close(descriptor_);
}

void OutputFolder::Write(const std::vector<NamedText>& files, const std::vector<LongText>& long_files) const {
  CheckInterruption();
  std::vector<LongText> all = long_files;
  for (const auto& [name, text] : files) all.push_back(InOnePiece(name, text));
  if (all.size() == 1) return CommitOne(descriptor_, path_, all[0]);
  const DeferredSignals deferred;
  Temporaries results(descriptor_, path_);
  for (const LongText& text : all) results.Add(kTemporary, text);
  const std::string list = results.Note();
  Temporaries note(descriptor_, path_);
  note.Add(kTemporary, InOnePiece(kNote, list));
  note.Rename();
  results.Keep();
  FinishNote(descriptor_, path_);
  fsync(descriptor_);
}

void FinishInterruptedWrite(const std::string& folder_path) {
  if (access(PathIn(folder_path, kNote).c_str(), F_OK) != 0) return;
  const Descriptor folder(OpenFolder(folder_path));
  if (folder.value() < 0) return;
  while (flock(folder.value(), LOCK_EX) != 0 && errno == EINTR) {
  }
  if (HasNote(folder.value())) FinishNote(folder.value(), folder_path);
}

}  // namespace sagitta
