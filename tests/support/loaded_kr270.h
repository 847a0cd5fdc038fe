// A loaded KR-270 measured by a generator of its own: kinematics base to tip,
// joint torques from lever arms, equilibrium by plain fixed-point iteration, the
// spring's torque by numerical derivative of its energy. Nothing from models/:
// what is estimated does not prove itself.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>

#include "estimator/estimate/estimate.h"
#include "tests/support/kr270_experiment.h"
#include "tests/support/random_vector.h"

namespace sagitta::test {

constexpr double kWeightOf250Kg = 250 * 9.80665;  // N

struct SpringTruth {
  double L = 0.18472, a_x = 0.68593, a_y = 0.12330, s0 = 0.458;  // m, paper 002
  double Kc = 6.944e6;                                           // N/m; theirs: its preload bends A2 by degrees
  bool preload = true;

  double Energy(double q) const {
    const double stretch = std::hypot(a_x + L * std::sin(q), a_y + L * std::cos(q)) - s0;
    return 0.5 * Kc * stretch * stretch;
  }
  // -dU/dq by the five-point rule; error below 1e-9 N m.
  double Torque(double q) const {
    constexpr double h = 1e-3;
    return -(8 * (Energy(q + h) - Energy(q - h)) - (Energy(q + 2 * h) - Energy(q - 2 * h))) / (12 * h);
  }
};

struct LoadTruth {
  Vector3<double> force = Vector3<double>::Zero();             // N, in `frame`
  Vector3<double> moment = Vector3<double>::Zero();            // N m, about the point
  Vector3<double> point = Vector3<double>(0.28, 0.06, -0.15);  // m, flange frame
  WrenchFrame frame = WrenchFrame::kMeasurement;
};

struct LoadedTruth : Kr270Truth {
  // rad/(N m); paper 002, Table IX with k1 of its separate stage.
  std::array<double, 6> k = {0.623e-6, 0.302e-6, 0.416e-6, 2.786e-6, 3.483e-6, 2.074e-6};
  std::function<double(double)> k2_of_q2;  // replaces k[1] where set
  std::optional<SpringTruth> spring;
  std::map<std::string, LoadTruth> loads = {{"V250", {{0, 0, -kWeightOf250Kg}}}};
  double tool_mass = 0.0;
  Vector3<double> tool_com = Vector3<double>(0.1, 0.02, 0.05);
  double coupling = 0.0;                                                // A3 moves by coupling * q2 on top
  std::map<std::string, std::pair<int, Vector3<double>>> link_markers;  // id: after joint 0 or 1, point in that frame
};

// The arm at joint values with everything in: where axes and flange are, in the base.
struct ArmState {
  std::array<Vector3<double>, 6> axis, origin;
  Eigen::Matrix3d after_joint[2];  // orientation right after A1 and A2
  Eigen::Matrix3d flange = Eigen::Matrix3d::Identity();
  Vector3<double> flange_origin = Vector3<double>::Zero();
};

inline ArmState StateOfArm(const std::array<double, 6>& v, const std::array<double, 18>& e) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  ArmState s;
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  Vector3<double> p(0, 0, 0.750);
  const auto joint = [&](int j, const Eigen::Vector3d& about) {
    s.axis[j] = r * about;
    s.origin[j] = p;
    r = r * Turn(about, v[j]);
    if (j < 2) s.after_joint[j] = r;
  };
  joint(0, z);
  p += r * Vector3<double>(0.350 + e[0], e[1], 0);
  r = r * Turn(x, e[2]);
  joint(1, y);
  p += r * Vector3<double>(1.250 + e[4], 0, 0);
  r = r * Turn(x, e[5]) * Turn(z, e[6]);
  joint(2, y);
  p += r * Vector3<double>(1.100 + e[8], 0, -0.055 + e[9]);
  r = r * Turn(z, e[10]);
  joint(3, x);
  p += r * Vector3<double>(0, e[12], e[13]);
  r = r * Turn(z, e[14]);
  joint(4, y);
  p += r * Vector3<double>(0, 0, e[16]);
  r = r * Turn(z, e[17]);
  joint(5, x);
  s.flange = r;
  s.flange_origin = p + r * Vector3<double>(0.230, 0, 0);
  return s;
}

// Deflections theta_j = k_j tau_j(q + theta), iterated until they stand.
inline ArmState LoadedState(const LoadedTruth& truth, const Eigen::VectorXd& q, const std::string& load, int station) {
  const Eigen::Matrix3d base = BaseRotation(truth, station);
  std::array<double, 6> unbent{}, deflection{};
  for (int j = 0; j < 6; ++j) unbent[j] = q[j];
  unbent[2] += truth.coupling * q[1];
  unbent[1] += truth.errors[3];
  unbent[2] += truth.errors[7];
  unbent[3] += truth.errors[11];
  unbent[4] += truth.errors[15];
  for (int iteration = 0;; ++iteration) {
    std::array<double, 6> values{};
    for (int j = 0; j < 6; ++j) values[j] = unbent[j] + deflection[j];
    const ArmState state = StateOfArm(values, truth.errors);
    std::array<double, 6> torque{};
    const auto apply = [&](const Vector3<double>& point, const Vector3<double>& force, const Vector3<double>& moment) {
      const Vector3<double> at = state.flange_origin + state.flange * point;
      for (int j = 0; j < 6; ++j) torque[j] += state.axis[j].dot((at - state.origin[j]).cross(force) + moment);
    };
    if (truth.tool_mass > 0) {
      apply(truth.tool_com, base.transpose() * Vector3<double>(0, 0, -9.80665 * truth.tool_mass), {0, 0, 0});
    }
    if (load != "none") {
      const LoadTruth& l = truth.loads.at(load);
      Eigen::Matrix3d turn = base.transpose();
      if (l.frame == WrenchFrame::kBase) turn.setIdentity();
      if (l.frame == WrenchFrame::kFlange) turn = state.flange;
      apply(l.point, turn * l.force, turn * l.moment);
    }
    if (truth.spring) {
      torque[1] += truth.spring->Torque(values[1]);
      if (!truth.spring->preload) torque[1] -= truth.spring->Torque(q[1]);
    }
    double change = 0.0;
    for (int j = 0; j < 6; ++j) {
      const double k = j == 1 && truth.k2_of_q2 ? truth.k2_of_q2(q[1]) : truth.k[j];
      change = std::max(change, std::abs(k * torque[j] - deflection[j]));
      deflection[j] = k * torque[j];
    }
    if (change < 1e-16 || iteration == 200) return state;
  }
}

// Two tilted stations, a load on the arm's end, two sideways pulls, the spring of paper 002, a marker on A1 and one on
// A2.
inline LoadedTruth Everything() {
  LoadedTruth truth;
  truth.base_rotvec = {{0.0528, 0.01, 0.3}, {-0.04, 0.02, -1.0}};
  truth.base_xyz = {{0.1, 0.2, 0.3}, {3.0, -1.0, 0.2}};
  truth.loads["PX"] = {{500, 0, 0}};
  truth.loads["PY"] = {{0, 500, 0}};
  truth.spring = SpringTruth();
  truth.link_markers = {{"B1", {0, {0.3, 0.2, 0.1}}}, {"B2", {1, {0.1, 0.2, 0.15}}}};
  return truth;
}

struct LoadedDesign : Kr270Design {
  LoadedDesign() {
    configurations = 20;
    sigma = 3e-5;
  }
  std::vector<std::string> loads = {"V250"};  // each in every configuration
  std::vector<std::string> pulls;             // each in the first `pulled` configurations only
  int pulled = 3;
  bool unloaded = true;
  std::function<void(std::vector<Configuration>*)> change;  // of the drawn configurations
};

// In the first three configurations two sideways pulls in addition to the load.
inline LoadedDesign WithPulls() {
  LoadedDesign design;
  design.pulls = {"PX", "PY"};
  return design;
}

// Rows without points: every load state of a configuration is one shot of its station.
inline Measurements LoadedRows(const LoadedDesign& design, const LoadedTruth& truth) {
  Measurements data = DesignMeasurements(design);
  const std::vector<Shot> once = data.shots;
  data.shots.clear();
  data.observations.clear();
  data.files[0].rows.clear();
  for (const auto& [name, marker] : truth.link_markers) data.markers.push_back(name);
  if (design.change) design.change(&data.configurations);
  for (size_t c = 0; c < once.size(); ++c) {
    std::vector<std::string> states = design.loads;
    if (design.unloaded) states.insert(states.begin(), "none");
    if (static_cast<int>(c) < design.pulled) states.insert(states.end(), design.pulls.begin(), design.pulls.end());
    for (const std::string& state : states) {
      Shot shot = once[c];
      shot.load = state;
      if (state != "none") {
        shot.wrench.force = truth.loads.at(state).force;
        shot.wrench.moment = truth.loads.at(state).moment;
      }
      AddShot(shot, static_cast<int>(data.markers.size()), design.sigma, &data);
    }
  }
  return data;
}

// The points without noise, one per row.
inline std::vector<Vector3<double>> ExactPoints(const LoadedTruth& truth, const Measurements& data) {
  std::vector<Vector3<double>> points;
  std::map<int, ArmState> states;
  for (const Observation& observation : data.observations) {
    const Shot& shot = data.shots[observation.shot];
    auto found = states.find(observation.shot);
    if (found == states.end()) {
      const Eigen::VectorXd& q = data.configurations[shot.configuration].q;
      found = states.emplace(observation.shot, LoadedState(truth, q, shot.load, shot.station)).first;
    }
    const ArmState& arm = found->second;
    Vector3<double> in_base;
    const auto link = truth.link_markers.find(data.markers[observation.marker]);
    if (link != truth.link_markers.end()) {
      const int joint = link->second.first;
      in_base = arm.origin[joint] + arm.after_joint[joint] * link->second.second;
    } else {
      in_base = arm.flange_origin + arm.flange * truth.tools[observation.marker];
    }
    points.push_back(truth.base_xyz[shot.station] + BaseRotation(truth, shot.station) * in_base);
  }
  return points;
}

inline void Measure(const std::vector<Vector3<double>>& exact, double sigma, std::uint64_t seed, Measurements* data) {
  NormalNumbers normal(seed);
  for (size_t i = 0; i < exact.size(); ++i) {
    const Vector3<double> noise = test::RandomVector(normal);
    data->observations[i].point_in_station = exact[i] + sigma * noise;
  }
}

// Robot and experiment as files would state them: nominal geometry, no
// compliance known, the spring off by a few per cent but for L.
struct LoadedSetup {
  Robot robot;
  Experiment experiment;
};

inline LoadedSetup SetupFor(const LoadedTruth& truth) {
  LoadedSetup setup;
  setup.robot.name = "KR 270";
  setup.robot.chain = Kr270Chain();
  if (truth.coupling != 0.0) setup.robot.chain.couplings.push_back({2, 1, truth.coupling});
  if (truth.spring) {
    const SpringTruth& s = *truth.spring;
    const double off = s.preload ? 0.01 : 0.0;  // its stiffness alone does not determine where it is fixed
    setup.robot.gravity_compensator =
        GravityCompensator{1, s.L, s.a_x * (1 + off), s.a_y * (1 - 2 * off), s.s0 * 1.01, s.Kc * 0.9, s.preload};
    setup.experiment.estimate.gravity_compensator = {Selection::Kind::kList, {"s0", "Kc"}};
    if (s.preload) setup.experiment.estimate.gravity_compensator.names = {"a_x", "a_y", "s0", "Kc"};
  }
  for (const auto& [name, load] : truth.loads) {
    LoadSpec spec;
    spec.point = load.point;
    spec.frame = load.frame;
    setup.experiment.loads[name] = spec;
  }
  setup.experiment.tool_mass = truth.tool_mass;
  setup.experiment.tool_com = truth.tool_com;
  for (const auto& [name, marker] : truth.link_markers) {
    setup.experiment.markers[name].on = MarkerPlace::Named(marker.first == 0 ? "A1" : "A2");
  }
  return setup;
}

inline double TrueLoadedValue(const LoadedTruth& truth, const std::string& name) {
  if (name.rfind("compliance/A", 0) == 0) {
    const size_t at = name.find('@');
    if (at != std::string::npos) return truth.k2_of_q2(std::stod(name.substr(at + 1)) * kDegree);
    return truth.k[name[12] - '1'];
  }
  if (name.rfind("compensator/", 0) == 0) {
    const SpringTruth& s = *truth.spring;
    const std::string which = name.substr(12);
    return which == "L" ? s.L : which == "a_x" ? s.a_x : which == "a_y" ? s.a_y : which == "s0" ? s.s0 : s.Kc;
  }
  if (name.rfind("marker/", 0) == 0) {
    const auto link = truth.link_markers.find(name.substr(7, name.size() - 9));
    if (link != truth.link_markers.end()) return link->second.second[name.back() - 'x'];
  }
  return TrueValue(truth, name);
}

// Estimate minus truth of an estimated coordinate; a rotation as left perturbation, as its sigma is.
inline double ErrorOf(const Estimate& estimate, const LoadedTruth& truth, int coordinate) {
  const Coordinate& c = estimate.parameters.coordinates()[coordinate];
  const double difference = estimate.parameters.Value(coordinate) - TrueLoadedValue(truth, c.name);
  if (c.quantity != Quantity::kRotationVector) return difference;
  const int station = estimate.parameters.blocks()[c.block].owner;
  const Eigen::AngleAxisd turn(estimate.parameters.BaseInStation(station).rotation *
                               BaseRotation(truth, station).transpose());
  return turn.angle() * turn.axis()[c.index_in_block];
}

// error' C^-1 error over all estimated coordinates.
inline double SquaredDistanceToTruth(const Estimate& estimate, const LoadedTruth& truth) {
  Eigen::VectorXd z(estimate.estimated.size());
  const Eigen::VectorXd inverse = estimate.covariance.diagonal().cwiseSqrt().cwiseInverse();
  for (int c = 0; c < z.size(); ++c) z[c] = ErrorOf(estimate, truth, estimate.estimated[c]) * inverse[c];
  const Eigen::MatrixXd correlation = inverse.asDiagonal() * estimate.covariance * inverse.asDiagonal();
  return z.dot(correlation.ldlt().solve(z));
}

}  // namespace sagitta::test
