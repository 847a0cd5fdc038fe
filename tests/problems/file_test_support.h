// Temporary files and the InputError that reading them gives.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "problems/input_error.h"
#include "problems/io/measurement_file.h"

namespace sagitta {

// A folder of its own for the running test, removed afterwards.
class FileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const ::testing::TestInfo* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "." + info->name() + "." + std::to_string(getpid());
    for (char& c : name) c = c == '/' ? '_' : c;
    folder_ = ::testing::TempDir() + name;
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
    return Path(name);
  }

  std::string folder_;
};

// The text with its first `from` replaced; the test is wrong when it is absent.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "'" << from << "' is not in the text";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// Of a robot with joints of these names, revolute or prismatic.
inline Measurements ReadMeasurements(const std::vector<std::string>& paths, const std::vector<std::string>& joints,
                                     const std::vector<bool>& prismatic, const MeasurementReadOptions& options = {}) {
  Robot robot;
  for (size_t j = 0; j < joints.size(); ++j) {
    Joint joint;
    joint.name = joints[j];
    if (prismatic[j]) joint.type = JointType::kPrismatic;
    robot.chain.joints.push_back(joint);
  }
  return ReadMeasurementsFor(robot, paths, options);
}

// What the error says, "" when nothing is thrown.
template <typename Function>
std::string ErrorOf(const Function& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// `message` has every part, in this order.
inline ::testing::AssertionResult SaysInOrder(const std::string& message, const std::vector<std::string>& parts) {
  size_t at = 0;
  for (const std::string& part : parts) {
    at = message.find(part, at);
    if (at == std::string::npos) {
      return ::testing::AssertionFailure() << "'" << part << "' is not (in its place) in: '" << message << "'";
    }
    at += part.size();
  }
  return ::testing::AssertionSuccess();
}

}  // namespace sagitta
