// Results are whole or as they were: sets of files, kills at every moment, links, permissions, locks, inputs.
#include "problems/io/output_files.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/user.h>
#include <sys/wait.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <iostream>
#include <memory>
#include <set>

#include "problems/interruption.h"
#include "problems/io/files.h"
#include "problems/limits.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::output_files_test {
namespace {

namespace fs = std::filesystem;

class OutputFilesTest : public FileTest {
 protected:
  std::set<std::string> Names(const std::string& folder) const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(Path(folder))) names.insert(entry.path().filename().string());
    return names;
  }
  void WriteSet(const std::string& text) const {
    OutputFolder(Path("out"), {"a", "b", "c"}).Write({{"a", text}, {"b", text}, {"c", text}});
  }
};

TEST_F(OutputFilesTest, ASetIsWrittenAndNothingElse) {
  WriteSet("1");
  WriteSet("2");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "b", "c"}));
  EXPECT_EQ(ReadTextFile(Path("out/b")), "2");
}

// One of two cannot be written: the other is as it was.
TEST_F(OutputFilesTest, FilesOfOneRunAreWrittenTogether) {
  const OutputFile first(Path("a/one")), second(Path("b/two"));
  OutputFile::WriteTogether({{&first, "1"}, {&second, "2"}});
  EXPECT_EQ(ReadTextFile(Path("a/one")), "1");
  EXPECT_EQ(ReadTextFile(Path("b/two")), "2");
  fs::remove_all(Path("b"));
  EXPECT_THROW(OutputFile::WriteTogether({{&first, "new"}, {&second, "new"}}), InputError);
  EXPECT_EQ(ReadOwnFile(Path("a/one")), "1");
  EXPECT_EQ(Names("a"), std::set<std::string>{"one"});
}

// Piece by piece or all at once makes no difference; a text that breaks off leaves the set as it was.
TEST_F(OutputFilesTest, ALongTextIsWholeOrAsItWas) {
  const auto write = [this](const std::string& text, int pieces, bool breaks) {
    const auto in_pieces = [&](const TextSink& sink) {
      for (int i = 0; i < pieces; ++i) sink(text);
      if (breaks) throw std::runtime_error("no more");
    };
    OutputFolder(Path("out"), {"a", "long"}).Write({{"a", text}}, {{"long", in_pieces}});
  };
  write("old", 3, false);
  EXPECT_EQ(ReadTextFile(Path("out/long")), "oldoldold");
  EXPECT_THROW(write("new", 2, true), std::runtime_error);
  EXPECT_EQ(ReadTextFile(Path("out/long")), "oldoldold");
  EXPECT_EQ(ReadTextFile(Path("out/a")), "old");
  write("new", 0, false);
  EXPECT_EQ(ReadTextFile(Path("out/long")), "");
  EXPECT_EQ(ReadTextFile(Path("out/a")), "new");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "long"}));
}

TEST_F(OutputFilesTest, WhatWasInterruptedIsNotWritten) {
  std::atomic<bool> stop{false};
  const Interruptible scope(&stop);
  WriteSet("1");
  stop = true;
  EXPECT_THROW(WriteSet("2"), Interruption);
  EXPECT_THROW(OutputFile(Path("out/a")).Write("2"), Interruption);
  EXPECT_EQ(ReadTextFile(Path("out/a")), "1");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "b", "c"}));
}

TEST_F(OutputFilesTest, FoldersThatStayEmptyAreTakenAway) {
  { const OutputFolder out(Path("x/y/"), {"a"}); }
  EXPECT_FALSE(fs::exists(Path("x")));
  { const OutputFile out(Path("x/y/a")); }
  EXPECT_FALSE(fs::exists(Path("x")));
  OutputFile(Path("x/y/a")).Write("1");
  EXPECT_EQ(ReadTextFile(Path("x/y/a")), "1");
  { const OutputFolder out(Path("x"), {"b"}); }
  EXPECT_TRUE(fs::exists(Path("x/y/a")));
}

TEST_F(OutputFilesTest, RefusesAnImpossibleFolder) {
  Write("file", "x");
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFolder(Path("file"), {"a"}); }), {"file", "a file"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFolder(Path("file/sub"), {"a"}); }), {"file/sub"}));
  EXPECT_NE(ErrorOf([&] { OutputFolder("/proc/sagitta/out", {"a"}); }), "");
  EXPECT_NE(ErrorOf([&] { OutputFolder("/proc", {"a"}); }), "");
  EXPECT_NE(ErrorOf([&] { OutputFolder("", {"a"}); }), "");
  EXPECT_EQ(ReadTextFile(Path("file")), "x");
}

// One name of three is that of a folder: the other two stay as they were.
TEST_F(OutputFilesTest, WhatCannotBeWrittenLeavesAllAsItWas) {
  WriteSet("old");
  const OutputFolder out(Path("out"), {"a", "b", "c"});
  fs::remove(Path("out/c"));
  fs::create_directories(Path("out/c/full"));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { out.Write({{"a", "new"}, {"b", "new"}, {"c", "new"}}); }), {"out/c"}));
  EXPECT_EQ(ReadTextFile(Path("out/a")), "old");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "b", "c"}));
}

TEST_F(OutputFilesTest, ADeviceIsNoPlaceForResults) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([] { OutputFile("/dev/null"); }), {"/dev/null", "regular files"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([] { WriteTextFile("/dev/full", "x"); }), {"/dev/full", "regular files"}));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputFilesTest, PermissionsOfAReplacedFileAreKept) {
  for (const mode_t mode : {0600, 0640, 0444}) {
    WriteTextFile(Path("f"), "1");
    ASSERT_EQ(chmod(Path("f").c_str(), mode), 0);
    WriteTextFile(Path("f"), "2");
    struct stat status;
    ASSERT_EQ(stat(Path("f").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, mode);
    fs::remove(Path("f"));
  }
  const mode_t before = umask(027);
  WriteTextFile(Path("f"), "1");
  umask(before);
  struct stat status;
  ASSERT_EQ(stat(Path("f").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0640);
}

// A link in the place of a result is replaced; what it points to is not touched.
TEST_F(OutputFilesTest, LinksAreNotFollowed) {
  Write("target", "precious");
  fs::create_symlink(Path("target"), Path("result"));
  WriteTextFile(Path("result"), "new");
  EXPECT_EQ(ReadTextFile(Path("target")), "precious");
  EXPECT_FALSE(fs::is_symlink(Path("result")));
  EXPECT_EQ(ReadTextFile(Path("result")), "new");
}

TEST_F(OutputFilesTest, OneRunAtATime) {
  fs::create_directory(Path("out"));
  const OutputFolder first(Path("out"), {"a"});
  const pid_t child = fork();
  if (child == 0) {
    const bool refused = ErrorOf([&] { OutputFolder(Path("out"), {"a"}); }).find("another run") != std::string::npos;
    _exit(refused ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  // Other folders are nobody's business.
  OutputFolder(Path("other"), {"a"}).Write({{"a", "1"}});
}

// Killed at its k-th stop, before or after a system call, for every second k, which leaves out none of the calls: all
// files are those of before or all are new, and the next run neither waits nor trips.
// Kills `write` at its k-th system call, entry or return, for every k until it ends by itself. False: this machine
// allows no tracing.
bool KillEverywhere(const std::function<void()>& prepare, const std::function<void()>& write,
                    const std::function<void(int)>& look) {
  for (int k = 0; k < 4000; ++k) {
    prepare();
    const pid_t child = fork();
    if (child == 0) {
      ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
      raise(SIGSTOP);
      try {
        write();
      } catch (...) {
      }
      _exit(0);
    }
    int status = 0;
    bool ended = false;
    waitpid(child, &status, 0);
    for (int stop = 0; stop <= k && !ended; ++stop) {
      if (ptrace(PTRACE_SYSCALL, child, nullptr, nullptr) != 0) return false;
      waitpid(child, &status, 0);
      ended = WIFEXITED(status);
    }
    if (!ended) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
    }
    look(k);
    if (ended) return true;
  }
  ADD_FAILURE() << "it does not end";
  return true;
}

TEST_F(OutputFilesTest, AKillAtAnyMomentMixesNothing) {
  int before = 0, after = 0;
  const auto look = [&](int k) {
    const std::string a = ReadTextFile(Path("out/a")), b = ReadTextFile(Path("out/b")), c = ReadTextFile(Path("out/c"));
    EXPECT_TRUE(a == b && b == c) << "killed at stop " << k << ": " << a << " " << b << " " << c;
    EXPECT_TRUE(a == "old" || a == "new") << a;
    (a == "old" ? before : after) += 1;
  };
  if (!KillEverywhere([this] { WriteSet("old"); }, [this] { WriteSet("new"); }, look)) GTEST_SKIP() << "no tracing";
  std::cout << before + after << " kills: " << before << " left the files of before, " << after << " the new ones\n";
  EXPECT_GT(before + after, 150);
  EXPECT_GT(before, 20);
  EXPECT_GT(after, 20);
  WriteSet("last");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "b", "c"}));
}

// The first results of a folder: none, or all.
TEST_F(OutputFilesTest, AKillBeforeTheFirstResultsLeavesNoneOrAll) {
  int none = 0, all = 0;
  const auto prepare = [this] { fs::remove_all(Path("new")); };
  const auto write = [this] { OutputFolder(Path("new/sub"), {"a", "b"}).Write({{"a", "1"}, {"b", "1"}}); };
  const auto look = [&](int k) {
    FinishInterruptedWrite(Path("new/sub"));
    const bool has_a = fs::exists(Path("new/sub/a")), has_b = fs::exists(Path("new/sub/b"));
    EXPECT_EQ(has_a, has_b) << "killed at stop " << k;
    for (const char* name : {"new/sub/a", "new/sub/b"}) {
      if (has_a && has_b) {
        EXPECT_EQ(ReadTextFile(Path(name)), "1");
      }
    }
    (has_a ? all : none) += 1;
  };
  if (!KillEverywhere(prepare, write, look)) GTEST_SKIP() << "no tracing";
  std::cout << none + all << " kills: " << none << " left no result, " << all << " all of them\n";
  EXPECT_GT(none, 20);
  EXPECT_GT(all, 5);
}

// One file: of before or new, and what a killed run left is gone after the next.
TEST_F(OutputFilesTest, AKillWhileOneFileIsWrittenLosesNothing) {
  int before = 0, after = 0;
  size_t most = 0;
  fs::create_directory(Path("one"));
  const std::string path = Path("one/result.csv");
  const auto write = [&](const char* text) { OutputFile(path).Write(text); };
  const auto look = [&](int k) {
    most = std::max(most, Names("one").size());
    const std::string text = ReadTextFile(path);
    EXPECT_TRUE(text == "old" || text == "new") << "killed at stop " << k << ": " << text;
    (text == "old" ? before : after) += 1;
    { const OutputFile next(Path("one/another.csv")); }
    EXPECT_EQ(Names("one"), (std::set<std::string>{"result.csv"})) << k;
  };
  if (!KillEverywhere([&] { write("old"); }, [&] { write("new"); }, look)) GTEST_SKIP() << "no tracing";
  std::cout << before + after << " kills: " << before << " left the file of before, " << after << " the new one\n";
  EXPECT_GT(before, 20);
  EXPECT_GT(after, 1);
  EXPECT_GT(most, 1u);  // some kill left something to sweep away
}

// Two runs may write one file each into a folder: neither sweeps away what the other has under its hands.
TEST_F(OutputFilesTest, WhatALivingRunWritesIsNotSweptAway) {
  fs::create_directory(Path("one"));
  Write("one/.sagitta-one-0123456789abcdef", "left by a killed run");
  const std::string busy = Write("one/.sagitta-one-fedcba9876543210", "being written");
  const int held = open(busy.c_str(), O_WRONLY);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  { const OutputFile out(Path("one/result.csv")); }
  EXPECT_EQ(Names("one"), (std::set<std::string>{".sagitta-one-fedcba9876543210"}));
  { const OutputFolder out(Path("one"), {"a", "b"}); }
  EXPECT_EQ(Names("one"), (std::set<std::string>{".sagitta-one-fedcba9876543210"}));
  close(held);
  { const OutputFolder out(Path("one"), {"a", "b"}); }
  EXPECT_FALSE(fs::exists(Path("one")) && !Names("one").empty());
}

// A file system of its own of some kB, gone with the object.
class SmallDisk {
 public:
  SmallDisk(std::string path, const std::string& options) : path_(std::move(path)) {
    fs::create_directories(path_);
    is_mounted_ = unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                  mount("none", path_.c_str(), "tmpfs", 0, options.c_str()) == 0;
  }
  ~SmallDisk() {
    if (is_mounted_) umount(path_.c_str());
  }
  bool is_mounted() const { return is_mounted_; }
  bool MakeReadOnly() const { return mount("none", path_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0; }

 private:
  std::string path_;
  bool is_mounted_ = false;
};

// Wherever the disk ends while a set is written, its files are those of before.
TEST_F(OutputFilesTest, AFullDiskLeavesTheResultsOfBefore) {
  const SmallDisk disk(Path("disk"), "size=128k");
  if (!disk.is_mounted()) GTEST_SKIP() << "this machine lets nobody mount";
  const auto write = [this](const std::string& text) {
    OutputFolder(Path("disk"), {"a", "b", "c"}).Write({{"a", text}, {"b", text}, {"c", text}});
  };
  write("old");
  int full = 0, written = 0;
  for (int pages = 0; pages <= 32; ++pages) {
    const std::string text(4096 * pages + 1, 'x');
    const std::string error = ErrorOf([&] { write(text); });
    const std::string a = ReadTextFile(Path("disk/a")), b = ReadTextFile(Path("disk/b")),
                      c = ReadTextFile(Path("disk/c"));
    EXPECT_TRUE(a == b && b == c) << pages;
    EXPECT_EQ(Names("disk"), (std::set<std::string>{"a", "b", "c"})) << pages;
    if (error.empty()) {
      EXPECT_EQ(a, text);
      ++written;
    } else {
      EXPECT_TRUE(SaysInOrder(error, {"disk/", "cannot be written", "No space left"})) << error;
      EXPECT_LT(a.size(), text.size());
      ++full;
    }
  }
  EXPECT_GT(written, 3);
  EXPECT_GT(full, 10);
  write("small again");
  EXPECT_EQ(ReadTextFile(Path("disk/c")), "small again");
}

TEST_F(OutputFilesTest, AReadOnlyDiskIsSaid) {
  const SmallDisk disk(Path("disk"), "size=128k");
  if (!disk.is_mounted()) GTEST_SKIP() << "this machine lets nobody mount";
  OutputFolder(Path("disk"), {"a", "b"}).Write({{"a", "old"}, {"b", "old"}});
  ASSERT_TRUE(disk.MakeReadOnly());
  const std::vector<std::string> of_folder = {"disk", "Read-only"};
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFolder(Path("disk"), {"a", "b"}); }), of_folder));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFolder(Path("disk/sub"), {"a", "b"}); }), of_folder));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFile(Path("disk/a")); }), of_folder));
  EXPECT_EQ(ReadTextFile(Path("disk/a")) + ReadTextFile(Path("disk/b")), "oldold");
}

// The folder goes while the run computes.
TEST_F(OutputFilesTest, AFolderThatIsTakenAwayIsSaid) {
  const auto out = std::make_unique<OutputFolder>(Path("out"), std::vector<std::string>{"a", "b"});
  fs::remove_all(Path("out"));
  EXPECT_NE(ErrorOf([&] { out->Write({{"a", "1"}, {"b", "1"}}); }), "");
  EXPECT_FALSE(fs::exists(Path("out")));
}

// Another tool sees no name of ours that it could prepare.
TEST_F(OutputFilesTest, ANoteThatIsNoneOfOursIsNotObeyed) {
  fs::create_directory(Path("out"));
  Write("precious", "x");
  Write("out/.sagitta-to-rename", "../precious a\n");
  EXPECT_NE(ErrorOf([&] { OutputFolder(Path("out"), {"a"}); }), "");
  EXPECT_EQ(ReadTextFile(Path("precious")), "x");
}

TEST_F(OutputFilesTest, NoOutputIsAnInputByWhateverName) {
  Write("rows.csv", "x");
  fs::create_symlink(Path("rows.csv"), Path("link.csv"));
  fs::create_hard_link(Path("rows.csv"), Path("hard.csv"));
  fs::create_directory(Path("sub"));
  for (const char* name : {"rows.csv", "sub/../rows.csv", "link.csv", "hard.csv"}) {
    {
      const FileSession session;
      ReadTextFile(Path("rows.csv"));
      ForgetText(Path("rows.csv"));
      EXPECT_TRUE(SaysInOrder(ErrorOf([&] { OutputFile(Path(name)); }), {"rows.csv", "overwritten", name})) << name;
    }
    const FileSession session;
    const OutputFile out(Path(name));
    EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadTextFile(Path("rows.csv")); }), {"rows.csv", "overwritten", name}));
  }
  EXPECT_EQ(ReadTextFile(Path("rows.csv")), "x");
}

TEST_F(OutputFilesTest, ASessionReadsEachFileOnce) {
  Write("rows.csv", "before");
  {
    const FileSession session;
    EXPECT_EQ(ReadTextFile(Path("rows.csv")), "before");
    Write("rows.csv", "replaced");
    EXPECT_EQ(ReadTextFile(Path("rows.csv")), "before");
    EXPECT_EQ(ReadOwnFile(Path("rows.csv")), "replaced");
    ForgetText(Path("rows.csv"));
    EXPECT_EQ(ReadTextFile(Path("rows.csv")), "replaced");
  }
  EXPECT_EQ(ReadTextFile(Path("rows.csv")), "replaced");
}

TEST_F(OutputFilesTest, ReadingEnds) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([] { ReadTextFile("/dev/zero"); }), {"/dev/zero", "256 MB"}));
}

}  // namespace
}  // namespace sagitta::output_files_test
