// Runs the built program as a user does.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/paths.h"

namespace sagitta::test {

struct Outcome {
  int status = -1;
  std::string out, err;
};

inline std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Each test has a folder of its own, gone when it passes.
class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name =
        "sagitta_" + std::string(info->test_suite_name()) + "_" + info->name() + std::to_string(getpid());
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!HasFailure()) std::filesystem::remove_all(folder_);
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  bool Exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  std::string Read(const std::string& name) const { return ReadAll(folder_ / name); }
  nlohmann::json ReadJson(const std::string& name) const { return nlohmann::json::parse(Read(name)); }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return Path(name);
  }

  Outcome Run(const std::vector<std::string>& arguments) const {
    std::string command = "'" + test::Program() + "'";
    for (const std::string& argument : arguments) command += " '" + argument + "'";
    command += " >'" + Path("stdout") + "' 2>'" + Path("stderr") + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Read("stdout"), Read("stderr")};
  }

 private:
  std::filesystem::path folder_;
};

inline std::string Published(const std::string& name) { return test::SourceFolder() + "/problems/published/" + name; }

// Lines of a CSV text as cells; no quotes in these files.
inline std::vector<std::vector<std::string>> Cells(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else if (c != '\r') {
        cells.back() += c;
      }
    }
    rows.push_back(cells);
  }
  return rows;
}

inline std::string Csv(const std::vector<std::vector<std::string>>& rows) {
  std::string text;
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) text += (c > 0 ? "," : "") + row[c];
    text += "\n";
  }
  return text;
}

inline int Column(const std::vector<std::vector<std::string>>& rows, const std::string& name) {
  for (size_t c = 0; c < rows[0].size(); ++c) {
    if (rows[0][c] == name) return static_cast<int>(c);
  }
  ADD_FAILURE() << "no column " << name;
  return 0;
}

}  // namespace sagitta::test
