#include "estimator/diagnosis/compensator_search.h"

#include <algorithm>
#include <cmath>

#include <Eigen/QR>

#include "models/gravity_compensator.h"

namespace sagitta {
namespace {

constexpr double kLever = 0.2;                                // m: L of every start; the gauge makes it free
constexpr double kRatios[] = {1.3, 1.8, 2.5, 3.5, 5.0, 8.0};  // a / L
constexpr int kNumRatios = sizeof(kRatios) / sizeof(kRatios[0]);
constexpr int kDirections = 24;  // of the anchor around the joint
constexpr size_t kTriedFromMiddle = 2;
constexpr double kTwoPi = 6.283185307179586;
constexpr double kAnchorReach = 1.5;  // m, prior standard deviation of a_x, a_y
constexpr double kSpringRest = 0.5;   // m, prior of s0 and its standard deviation

// One commanded angle per row of the linearization.
Eigen::VectorXd JointAngles(const CalibrationProblem& problem, int joint) {
  const std::vector<int> observations = problem.CalibrationObservations();
  Eigen::VectorXd q(3 * observations.size());
  for (size_t o = 0; o < observations.size(); ++o) {
    q.segment<3>(3 * o).setConstant(problem.data.ConfigurationOf(problem.data.observations[observations[o]]).q[joint]);
  }
  return q;
}

// Torque per unit of Kc and of Kc s0.
Eigen::MatrixX2d TorquesPerRate(const CompensatorParameters<double>& unit, const Eigen::VectorXd& q) {
  Eigen::MatrixX2d torques(q.size(), 2);
  for (int r = 0; r < q.size(); ++r) {
    torques(r, 0) = CompensatorTorque(unit, q[r]);  // s0 = 0: -a L sin(gamma)
    torques(r, 1) = -torques(r, 0) / CompensatorSpringLength(unit, q[r]);
  }
  return torques;
}

// Whether no neighbour on the grid of ratios and directions explains more.
bool IsPeak(const std::vector<CompensatorShape>& shapes, int ratio, int direction) {
  const auto reduction = [&](int r, int d) {
    return shapes[r * kDirections + (d + kDirections) % kDirections].reduction;
  };
  for (int r = std::max(0, ratio - 1); r <= std::min(kNumRatios - 1, ratio + 1); ++r) {
    for (int d = direction - 1; d <= direction + 1; ++d) {
      if (reduction(r, d) > reduction(ratio, direction)) return false;
    }
  }
  return true;
}

// Start values from the linear solution (Kc, Kc s0); a spring that no machine
// has (negative rate or rest length) goes behind the others.
void Seed(const Eigen::Vector2d& solution, CompensatorShape* shape) {
  std::vector<double>& p = shape->start.values;
  const double longest = 2.0 * std::hypot(p[1], p[2]) + 2.0 * p[0];
  const double s0 = solution[0] > 0.0 ? solution[1] / solution[0] : -1.0;
  if (!(s0 > 0.0 && s0 < longest)) shape->reduction *= 0.5;
  p[3] = std::min(std::max(s0, 0.5 * p[0]), longest);
  p[4] = std::max(solution[0], 100.0);
}

}  // namespace

std::vector<int> ComplianceCoordinates(const ParameterSet& parameters, const std::string& joint) {
  std::vector<int> nodes;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const std::string& name = parameters.coordinates()[i].name;
    if (name == "compliance/" + joint || name.rfind("compliance/" + joint + "@", 0) == 0) nodes.push_back(i);
  }
  return nodes;
}

double ComplianceOf(const ParameterSet& parameters, const std::string& joint) {
  const std::vector<int> nodes = ComplianceCoordinates(parameters, joint);
  double sum = 0.0;
  for (const int i : nodes) sum += parameters.Value(i);
  return nodes.empty() ? 0.0 : sum / static_cast<double>(nodes.size());
}

SpringSeat SeatOf(const CalibrationProblem& problem, const ParameterSet& parameters, const std::string& joint,
                  const Eigen::VectorXd& deviation) {
  return {joint, ComplianceOf(parameters, joint), JointAngles(problem, problem.robot.chain.FindJoint(joint)),
          deviation};
}

Eigen::MatrixXd SpringColumns(const SpringSeat& seat, const EffectSpec& shape) {
  const std::vector<double>& p = shape.values;
  const Eigen::VectorXd per_torque = 1e6 * seat.compliance * seat.deviation;
  return per_torque.asDiagonal() * TorquesPerRate({p[0], p[1], p[2], 0.0, 1.0}, seat.angles);
}

std::vector<CompensatorShape> ScanCompensator(const SpringSeat& seat, const ProjectedResidual& residual) {
  std::vector<CompensatorShape> shapes;
  if (seat.compliance <= 0.0) return shapes;
  for (const double ratio : kRatios) {
    for (int d = 0; d < kDirections; ++d) {
      const double alpha = kTwoPi * d / kDirections;
      const double a_x = ratio * kLever * std::sin(alpha), a_y = ratio * kLever * std::cos(alpha);
      shapes.push_back({{"gravity_compensator", seat.joint, {}, {kLever, a_x, a_y, 0.0, 0.0}}, d, 0.0, {}});
    }
  }
  Eigen::MatrixXd columns(seat.deviation.size(), 2 * shapes.size());
  for (size_t s = 0; s < shapes.size(); ++s) columns.middleCols<2>(2 * s) = SpringColumns(seat, shapes[s].start);
  const Eigen::MatrixXd rest = residual.ProjectOff(columns);
  for (size_t s = 0; s < shapes.size(); ++s) {
    CompensatorShape& shape = shapes[s];
    shape.columns = columns.middleCols<2>(2 * s);
    const Eigen::MatrixXd own = rest.middleCols<2>(2 * s);
    const Eigen::Vector2d projected = own.transpose() * residual.residual();
    const Eigen::Vector2d c = -(own.transpose() * own).completeOrthogonalDecomposition().solve(projected);
    shape.reduction = -c.dot(projected);
    Seed(c, &shape);
  }
  // One shape per basin: its neighbours lead to the same optimum.
  std::vector<CompensatorShape> peaks;
  for (int ratio = 0; ratio < kNumRatios; ++ratio) {
    for (int direction = 0; direction < kDirections; ++direction) {
      if (IsPeak(shapes, ratio, direction)) peaks.push_back(shapes[ratio * kDirections + direction]);
    }
  }
  std::stable_sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) { return a.reduction > b.reduction; });
  // Along its direction a peak is flat: the best ones are tried from the middle of the ratios too.
  const size_t best = std::min(kTriedFromMiddle, peaks.size());
  for (size_t p = 0; p < best; ++p) {
    CompensatorShape middle = shapes[kNumRatios / 2 * kDirections + peaks[2 * p].direction];
    middle.reduction = std::min(middle.reduction, peaks[2 * p].reduction);
    peaks.insert(peaks.begin() + static_cast<long>(2 * p + 1), middle);
  }
  return peaks;
}

void BoundCompensatorShape(ParameterSet* parameters) {
  const auto prior = [&](const char* name, double value, double sigma) {
    const int i = parameters->FindCoordinate(name);
    if (i < 0 || !parameters->coordinates()[i].free) return;
    parameters->coordinate(i).prior_value = value;
    parameters->coordinate(i).prior_sigma = sigma;
  };
  prior("compensator/a_x", 0.0, kAnchorReach);
  prior("compensator/a_y", 0.0, kAnchorReach);
  prior("compensator/s0", kSpringRest, kSpringRest);
}

}  // namespace sagitta
