#include "tests/hidden_effects/generator/case_files.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

#include "tests/hidden_effects/generator/answer_json.h"

namespace hidden {
namespace {

constexpr double kCommonSigma = 16e-6;  // m, where rows do not state theirs
const double kDegree = std::acos(-1.0) / 180.0;

template <typename... Arguments>
std::string Text(const char* format, Arguments... arguments) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, arguments...);
  return buffer;
}

template <typename Container>
std::string Joined(const Container& items) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

std::ofstream Open(const std::filesystem::path& path) {
  std::ofstream file(path);
  if (!file) throw std::runtime_error("cannot write " + path.string());
  return file;
}

void WriteChain(const Arm& arm, std::ostream& out) {
  const char* names[6] = {"Tx", "Ty", "Tz", "Rx", "Ry", "Rz"};
  out << "kinematics:\n  chain:\n";
  for (const Element& element : arm.elements) {
    const bool turn = IsTurn(element.move);
    const std::string name = names[static_cast<int>(element.move)];
    out << "    - {";
    if (element.joint >= 0) {
      out << name << ": " << arm.joints[element.joint].name;
    } else {
      out << name << (turn ? "_deg: " : "_mm: ")
          << Text("%.9g", turn ? element.nominal / kDegree : element.nominal * 1e3);
    }
    if (!element.error.empty()) out << ", error: " << element.error;
    out << "}\n";
  }
}

void WriteDh(const Arm& arm, std::ostream& out) {
  out << "kinematics:\n  dh:\n    convention: standard\n    links:\n";
  for (int link = 0; link < arm.size(); ++link) {
    out << "      - {joint: " << arm.joints[link].name;
    for (const Element& element : arm.elements) {
      if (element.dh_link != link) continue;
      const bool turn = IsTurn(element.move);
      out << ", " << element.dh_quantity << (turn ? "_deg: " : "_mm: ")
          << Text("%.9g", turn ? element.nominal / kDegree : element.nominal * 1e3);
    }
    out << "}\n";
  }
}

bool IsLeftOut(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> BelievedCompliances(const Case& made) {
  std::vector<std::string> joints;
  if (!made.options.design.loaded) return joints;
  for (int j = 0; j < made.robot.arm.size(); ++j) {
    const std::string& name = made.robot.arm.joints[j].name;
    if (made.robot.compliance[j] > 0.0 && !IsLeftOut(made.left_out.compliances, name)) joints.push_back(name);
  }
  return joints;
}

void WriteRobot(const Case& made, const std::filesystem::path& folder) {
  std::ofstream out = Open(folder / "robot.yaml");
  const Arm& arm = made.robot.arm;
  out << "schema: sagitta/robot/1\nname: " << arm.name << "\njoints:\n";
  for (const JointLimits& joint : arm.joints) {
    const double unit = joint.prismatic ? 1e3 : 1.0 / kDegree;
    const char* suffix = joint.prismatic ? "mm" : "deg";
    out << "  - {name: " << joint.name << ", type: " << (joint.prismatic ? "prismatic" : "revolute") << ", min_"
        << suffix << ": " << Text("%.9g", joint.low * unit) << ", max_" << suffix << ": "
        << Text("%.9g", joint.high * unit) << "}\n";
  }
  if (arm.is_dh) WriteDh(arm, out);
  if (!arm.is_dh) WriteChain(arm, out);
  if (!made.robot.has_spring) return;
  const Spring& s = made.robot.spring;
  out << "gravity_compensator:\n  {joint: " << arm.joints[s.joint].name
      << Text(
             ", type: spring, L_mm: %.9g, a_x_mm: %.9g, a_y_mm: %.9g, s0_mm: %.9g, Kc_N_per_mm: %.9g, preload: true}\n",
             s.L * 1e3, s.a_x * 1e3, s.a_y * 1e3, s.s0 * 1e3, s.Kc * 1e-3);
}

std::string NoiseLine(const CaseOptions& options, bool is_sealed) {
  if (options.noise == "rows") return "noise: {from: rows}\n";
  if (is_sealed) return Text("noise: {sigma_mm: %g}\n", 1e3 * kCommonSigma);
  return options.noise == "repeats" ? "noise: {from: repeats}\n" : "";
}

void WriteExperiment(const Case& made, const std::filesystem::path& folder, bool is_sealed) {
  std::ofstream out = Open(folder / "experiment.yaml");
  out << "schema: sagitta/experiment/1\nrobot: robot.yaml\nmeasurements: [measurements.csv]\n";
  const Vector3d& p = made.robot.load_point;
  if (made.options.design.loaded) {
    out << Text("load_point_mm: [%g, %g, %g]\n", p.x() * 1e3, p.y() * 1e3, p.z() * 1e3);
  }
  out << NoiseLine(made.options, is_sealed);
  if (made.options.repeatability > 0.0) {
    const double stated = (is_sealed ? 1.0 : made.options.stated_factor) * made.options.repeatability / kMicro;
    std::vector<std::string> entries;
    for (const JointLimits& joint : made.robot.arm.joints) {
      if (!joint.prismatic) entries.push_back(joint.name + Text(": %g", stated));
    }
    out << "repeatability_urad: {" << Joined(entries) << "}\n";
  }
  std::vector<std::string> errors;
  for (const std::string& name : made.robot.free_errors) {
    if (!IsLeftOut(made.left_out.errors, name)) errors.push_back(name);
  }
  out << "estimate:\n  base: true\n  markers: true\n  geometry: [" << Joined(errors) << "]\n";
  const std::vector<std::string> compliances = BelievedCompliances(made);
  if (!compliances.empty()) out << "  compliance: [" << Joined(compliances) << "]\n";
  if (made.robot.has_spring) out << "  gravity_compensator: [Kc]\n";
  out << "validation: {fraction: 0.3, seed: 1}\n";
}

void WriteHeader(const Case& made, std::ostream& out) {
  const DesignOptions& design = made.options.design;
  out << "config,marker,station,load";
  for (int j = 0; j < made.robot.arm.size(); ++j)
    out << ",q" << j + 1 << (made.robot.arm.joints[j].prismatic ? "_mm" : "_deg");
  out << ",x_mm,y_mm,z_mm";
  if (made.options.noise == "rows") out << ",sigma_x_mm,sigma_y_mm,sigma_z_mm";
  if (made.options.repeated > 0) out << ",repeat";
  if (design.loaded) out << ",fx_N,fy_N,fz_N";
  if (design.time) out << ",time_s";
  if (design.temperature) out << ",temperature_degC";
  if (design.approach) {
    for (int j = 0; j < made.robot.arm.size(); ++j) out << ",approach" << j + 1;
  }
  out << "\n";
}

void WriteRow(const Case& made, const Shot& shot, const std::string& marker, int repeat, const Vector3d& point,
              int decimals, std::ostream& out) {
  const DesignOptions& design = made.options.design;
  out << Text("C%02d,", shot.config) << marker << "," << shot.station << "," << shot.load;
  for (int j = 0; j < made.robot.arm.size(); ++j) {
    const bool prismatic = made.robot.arm.joints[j].prismatic;
    out << Text(prismatic ? ",%.6f" : ",%.9f", prismatic ? shot.q[j] * 1e3 : shot.q[j] / kDegree);
  }
  for (int axis = 0; axis < 3; ++axis) out << Text(",%.*f", decimals, point[axis] * 1e3);
  for (int axis = 0; axis < 3 && made.options.noise == "rows"; ++axis) out << Text(",%.5f", shot.sigma[axis] * 1e3);
  if (made.options.repeated > 0) out << "," << repeat;
  if (design.loaded) out << Text(",%g,%g,%.10g", shot.force.x(), shot.force.y(), shot.force.z());
  if (design.time) out << Text(",%.1f", shot.time);
  if (design.temperature) out << Text(",%.3f", shot.air);
  if (design.approach) {
    for (const int direction : shot.approach) out << "," << direction;
  }
  out << "\n";
}

const char* const kOtherMarker = "M2";

std::string NameOfGroup(const CaseOptions& options) {
  if (options.group == "station") return "S" + std::to_string(options.design.stations);
  return options.group == "marker" ? kOtherMarker : options.group == "axis" ? "z" : "";
}

// What a group's factor makes of an error; seen: the point from the instrument.
Vector3d ScaledError(const CaseOptions& options, const Shot& shot, const std::string& marker, const Vector3d& seen,
                     Vector3d error) {
  const std::string name = NameOfGroup(options);
  const bool is_whole =
      (options.group == "station" && shot.station == name) || (options.group == "marker" && marker == name);
  if (is_whole) return options.group_factor * error;
  if (options.group == "axis") error.z() *= options.group_factor;
  if (options.group == "sight") {
    // Of what is stated per axis, along the direction that becomes the line of sight once each is divided by its sigma.
    const Vector3d along = seen.cwiseQuotient(shot.sigma).normalized();
    const double drawn = along.dot(error.cwiseQuotient(shot.sigma));
    error += (options.group_factor - 1.0) * drawn * shot.sigma.cwiseProduct(along);
  }
  return error;
}

// Noise, and outliers of 10 to 40 sigma on single coordinates of the stated share of rows.
Vector3d Noise(const CaseOptions& options, const Shot& shot, const std::string& marker, const Vector3d& seen,
               Stream* noise, Stream* outliers, bool* is_outlier) {
  Vector3d error = options.sigma_factor * shot.sigma.cwiseProduct(noise->NormalVector(1.0));
  error = ScaledError(options, shot, marker, seen, error);
  *is_outlier = outliers->Chance(options.outliers);
  if (*is_outlier) {
    const int axis = outliers->Below(3);
    error[axis] += outliers->Sign() * outliers->Uniform(10.0, 40.0) * shot.sigma[axis];
  }
  return error;
}

void WriteAnswer(const Case& made, const std::vector<std::string>& outliers) {
  const CaseOptions& options = made.options;
  nlohmann::json answer = {{"study", options.study},
                           {"case", options.number},
                           {"robot", options.robot},
                           {"configurations", options.design.configurations},
                           {"stations", options.design.stations},
                           {"repeatability_urad", options.repeatability / kMicro},
                           {"undeclared_repeatability_urad", options.undeclared_repeatability / kMicro},
                           {"sigma_factor", options.sigma_factor},
                           {"outliers", outliers},
                           {"scales", options.scales}};
  if (!options.group.empty()) {
    const std::string name = NameOfGroup(options);
    answer["group"] = {{"of", options.group}, {"factor", options.group_factor}, {"name", nullptr}};
    if (!name.empty()) answer["group"]["name"] = name;
  }
  answer["hidden"] = nlohmann::json::array();
  for (const HiddenEffect& effect : made.effects) answer["hidden"].push_back(AnswerOf(effect));
  Open(std::filesystem::path(options.answer_folder) / "answer.json") << answer.dump(1) << "\n";
}

void DrawErrors(const RobotKind& robot, Stream* random, Arm* arm) {
  for (const std::string& name : robot.free_errors) {
    for (Element& element : arm->elements) {
      if (element.error == name) element.deviation = random->Normal(IsTurn(element.move) ? 0.5e-3 : 0.3e-3);
    }
  }
}

void DrawSurroundings(const RobotKind& robot, int stations, Stream* random, Nature* nature) {
  for (int s = 0; s < stations; ++s) {
    StationPose& pose = nature->stations["S" + std::to_string(s + 1)];
    const double z = random->Uniform(-3.0, 3.0), y = random->Normal(3e-3), x = random->Normal(3e-3);
    pose.turn = SmallTurn(Vector3d(x, y, z));
    pose.origin = {random->Uniform(2.0, 4.0), random->Uniform(-2.0, 2.0), random->Uniform(-1.0, 0.5)};
  }
  const double spread = robot.marker_spread;
  for (const char* marker : {"M1", "M2", "M3"}) {
    const double far = random->Uniform(0.8, 1.4);
    nature->markers[marker] = Vector3d(0.3 * spread, 0, 0) + spread * random->Direction() * far;
  }
}

void DrawLatent(const Case& made, double sigma, Stream* random, std::vector<VectorXd>* latent) {
  for (int c = 0; c < made.options.design.configurations; ++c) {
    VectorXd deviation = VectorXd::Zero(made.robot.arm.size());
    for (int j = 0; j < made.robot.arm.size(); ++j) {
      if (!made.robot.arm.joints[j].prismatic) deviation[j] = random->Normal(sigma);
    }
    latent->push_back(deviation);
  }
}

}  // namespace

Case MakeCase(const CaseOptions& options) {
  Case made;
  made.options = options;
  made.robot = MakeRobot(options.robot);
  Stream design(options.study, options.number, Purpose::kDesign);
  Stream geometry(options.study, options.number, Purpose::kGeometry);
  Stream effect(options.study, options.number, Purpose::kEffect);
  made.design = MakeDesign(made.robot, options.design, &design);
  for (Shot& shot : made.design.shots) {
    if (options.noise != "rows") shot.sigma.setConstant(kCommonSigma);
  }
  Nature& nature = made.nature;
  nature.arm = made.robot.arm;
  DrawErrors(made.robot, &geometry, &nature.arm);
  DrawSurroundings(made.robot, options.design.stations, &geometry, &nature);
  while (static_cast<int>(nature.markers.size()) > options.markers) {
    nature.markers.erase(std::prev(nature.markers.end()));
  }
  nature.load_point = made.robot.load_point;
  const int n = nature.arm.size();
  nature.compliance = VectorXd::Zero(n);
  if (options.design.loaded) {
    for (int j = 0; j < n; ++j) nature.compliance[j] = made.robot.compliance[j] * geometry.Uniform(0.8, 1.25);
  }
  nature.hardening = VectorXd::Zero(n);
  nature.tilt_compliance.assign(n, Vector3d::Zero());
  if (made.robot.has_spring) nature.spring = made.robot.spring;
  double sum = 0.0;
  for (const Shot& shot : made.design.shots) sum += shot.air;
  nature.reference_temperature = sum / static_cast<double>(made.design.shots.size());
  for (size_t i = 0; i < options.kinds.size(); ++i) {
    made.effects.push_back(
        Hide(options.kinds[i], options.scales[i], made.robot, made.design, &effect, &nature, &made.left_out));
  }
  return made;
}

void WriteCase(const Case& made) {
  const CaseOptions& options = made.options;
  const std::filesystem::path open = options.folder, sealed = options.answer_folder;
  for (const auto& folder : {open, sealed}) {
    std::filesystem::create_directories(folder);
    WriteRobot(made, folder);
    WriteExperiment(made, folder, folder == sealed);
  }
  Nature noisy = made.nature;
  Stream repeatability(options.study, options.number, Purpose::kRepeatability);
  DrawLatent(made, std::hypot(options.repeatability, options.undeclared_repeatability), &repeatability, &noisy.latent);
  Stream noise(options.study, options.number, Purpose::kNoise);
  Stream thrown(options.study, options.number, Purpose::kOutliers);
  std::ofstream measured = Open(open / "measurements.csv"), exact = Open(sealed / "measurements.csv");
  WriteHeader(made, measured);
  WriteHeader(made, exact);
  std::vector<std::string> outliers;
  int line = 1;
  for (const Shot& shot : made.design.shots) {
    for (const auto& [marker, point] : made.nature.markers) {
      for (int repeat = 1; repeat <= (shot.config < options.repeated ? 2 : 1); ++repeat) {
        ++line;
        bool is_outlier = false;
        const Vector3d seen = SeenAt(noisy, shot, marker);
        const Vector3d error = Noise(options, shot, marker, seen, &noise, &thrown, &is_outlier);
        if (is_outlier) outliers.push_back("measurements.csv:" + std::to_string(line));
        WriteRow(made, shot, marker, repeat, seen + error, 6, measured);
        WriteRow(made, shot, marker, repeat, SeenAt(made.nature, shot, marker), 10, exact);
      }
    }
  }
  WriteAnswer(made, outliers);
}

}  // namespace hidden
