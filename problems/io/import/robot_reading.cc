#include "problems/io/import/robot_reading.h"

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/import/text_table.h"
#include "problems/io/robot_checks.h"
#include "problems/io/robot_file.h"
#include "problems/io/urdf_robot.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

enum class Format { kUrdf, kRobotYaml, kUrCalibration, kUrConf, kMatlab, kDhTable, kBodyTree, kOther };

Format FormatOf(const std::string& text, const std::string& path) {
  if (IsUrdf(path, text)) return Format::kUrdf;
  if (text.find("sagitta/robot/") != std::string::npos) return Format::kRobotYaml;
  if (LooksLikeUrCalibration(text)) return Format::kUrCalibration;
  const bool is_short = text.size() <= limits::kScriptBytes;
  if (is_short && LooksLikeUrConf(text)) return Format::kUrConf;
  if (text.find("Body Name") != std::string::npos && text.find("Joint Type") != std::string::npos)
    return Format::kBodyTree;
  if (LooksLikeDhTable(text, path)) return Format::kDhTable;
  if (is_short && LooksLikeMatlab(text)) return Format::kMatlab;
  return Format::kOther;
}

RobotReading Native(Robot robot, const std::string& format) {
  RobotReading reading;
  reading.robot = std::move(robot);
  reading.format = format;
  return reading;
}

RobotReading ReadByFormat(const std::string& bytes, const std::string& path, const RobotReadOptions& options) {
  std::string encoding;
  const std::string text = DecodeText(bytes, path, &encoding);
  switch (FormatOf(text, path)) {
    case Format::kUrdf:
      return Native(ReadUrdfText(text, path, options.ends), "URDF");
    case Format::kUrCalibration:
      return ReadUrCalibration(text, path);
    case Format::kUrConf:
      return ReadUrConf(text, path, options);
    case Format::kMatlab:
      return ReadMatlabText(text, path, options);
    case Format::kDhTable:
      return ReadDhText(bytes, path, options);
    case Format::kBodyTree:
      throw InputError({path, 0, ""}, "showdetails of a rigidBodyTree lists bodies without their transforms",
                       "exportrobot(robot, OutputFileName=\"robot.urdf\") writes them");
    case Format::kRobotYaml:
      return Native(ReadRobotText(text, path), "sagitta/robot/1");
    case Format::kOther:
      break;
  }
  throw InputError({path, 0, ""}, "this is no robot that can be read",
                   "robot.yaml, URDF, a DH table with columns a, alpha, d, theta, calibration.yaml or .conf of "
                   "Universal Robots, MATLAB text; the last two of at most 12 kB");
}

}  // namespace

RobotReading ReadAnyRobotText(const std::string& bytes, const std::string& path, const RobotReadOptions& options) {
  RobotReading reading = ReadByFormat(bytes, path, options);
  CheckRobot(reading.robot, path);
  return reading;
}

RobotReading ReadAnyRobot(const std::string& path, const RobotReadOptions& options) {
  return ReadAnyRobotText(ReadTextFile(path), path, options);
}

bool LooksLikeRobot(const std::string& path) {
  std::string encoding;
  const std::string text = DecodeText(ReadTextFile(path), path, &encoding);
  return FormatOf(text, path) != Format::kOther;
}

}  // namespace sagitta
