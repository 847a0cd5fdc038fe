// Results are whole or as they were: sets of files, kills at every moment, links, permissions, locks, inputs.
#include "problems/io/output_files.h"

#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/user.h>
#include <sys/wait.h>

#include <csignal>
#include <iostream>
#include <set>

#include "problems/io/files.h"
#include "problems/limits.h"
#include "tests/problems/file_test_support.h"

namespace sagitta {
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

// One name of three is taken by a folder: the other two stay as they were.
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
TEST_F(OutputFilesTest, AKillAtAnyMomentMixesNothing) {
  int before = 0, after = 0, k = 0;
  for (bool ended = false; !ended && k < 4000; k += 2) {
    WriteSet("old");
    const pid_t child = fork();
    if (child == 0) {
      ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
      raise(SIGSTOP);
      try {
        WriteSet("new");
      } catch (...) {
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    for (int stop = 0; stop <= k && !ended; ++stop) {
      if (ptrace(PTRACE_SYSCALL, child, nullptr, nullptr) != 0) GTEST_SKIP() << "this machine allows no tracing";
      waitpid(child, &status, 0);
      ended = WIFEXITED(status);
    }
    if (!ended) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
    }
    const std::string a = ReadTextFile(Path("out/a")), b = ReadTextFile(Path("out/b")), c = ReadTextFile(Path("out/c"));
    EXPECT_TRUE(a == b && b == c) << "killed at stop " << k << ": " << a << " " << b << " " << c;
    EXPECT_TRUE(a == "old" || a == "new") << a;
    (a == "old" ? before : after) += 1;
  }
  std::cout << before + after << " kills: " << before << " left the files of before, " << after << " the new ones\n";
  EXPECT_GT(before + after, 50);
  EXPECT_GT(before, 10);
  EXPECT_GT(after, 10);
  WriteSet("last");
  EXPECT_EQ(Names("out"), (std::set<std::string>{"a", "b", "c"}));
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
  }
  EXPECT_EQ(ReadTextFile(Path("rows.csv")), "replaced");
}

TEST_F(OutputFilesTest, ReadingEnds) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([] { ReadTextFile("/dev/zero"); }), {"/dev/zero", "256 MB"}));
}

}  // namespace
}  // namespace sagitta
