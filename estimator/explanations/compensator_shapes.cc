#include "estimator/explanations/compensator_shapes.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/explanations/driver_functions.h"
#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "models/gravity_compensator.h"

namespace sagitta {
namespace {

constexpr double kLever = 0.2;  // m: L of every shape; the gauge makes it free
// a / L of springs from short to long; beyond 8 the torque is a sine whatever the ratio (to 1 %).
constexpr double kRatios[] = {1.3, 1.8, 2.5, 3.5, 5.0, 8.0};
constexpr int kAnchorDirections = 24;  // of the anchor around the joint: neighbours differ by 15 degrees
constexpr double kAnchorReach = 1.5;   // m, prior standard deviation of a_x, a_y: the largest arms are as long
constexpr double kSpringRest = 0.5;    // m, prior of s0 and its standard deviation: the published one has 0.458
constexpr double kLeastRate = 100.0;   // N/m: of 1 m it holds 10 kg, and balances no arm
constexpr double kShortest = 0.1;      // of the longer lever: where both point the same way, |a - L| of spring is left
// Of a stated spring: coil springs are made to 5 to 10 % of their force (DIN EN 15800), gas springs lose as much with
// age; anchors are where drawings say to some millimetres, of castings.
constexpr double kTypicalSpringShare = 0.1, kTypicalAnchorError = 3e-3;
constexpr double kKeptWithin = 0.3;  // of a: 17 degrees and a factor of 1.35, about one cell of the grid either way

// Of an even distribution over a cell of the grid: its width over the root of 12. Ratios differ by factors of
// about 1.4.
const double kDirectionDeviation = 2.0 * kPi / kAnchorDirections / std::sqrt(12.0);
const double kRatioDeviation = std::log(1.4) / std::sqrt(12.0);

EffectSpec ShapeOf(const std::string& joint, double ratio, double alpha) {
  const double a_x = ratio * kLever * std::sin(alpha), a_y = ratio * kLever * std::cos(alpha);
  return {kGravityCompensator, joint, {}, {kLever, a_x, a_y, 0.0, 0.0}};
}

// Torque per unit of Kc and of Kc s0 for such a shape at each angle.
Eigen::MatrixX2d TorquesPerRate(const EffectSpec& shape, const Eigen::MatrixX2d& wave) {
  const CompensatorParameters<double> unit{shape.values[0], shape.values[1], shape.values[2], 0.0, 1.0};
  Eigen::MatrixX2d torques(wave.rows(), 2);
  for (long r = 0; r < wave.rows(); ++r) {
    torques(r, 0) = CompensatorTorque(unit, wave(r, 0), wave(r, 1));  // s0 = 0: -a L sin(gamma)
    torques(r, 1) = -torques(r, 0) / CompensatorSpringLength(unit, wave(r, 0), wave(r, 1));
  }
  return torques;
}

}  // namespace

bool IsSpringShape(const Coordinate& coordinate) {
  return coordinate.kind == CoordinateKind::kCompensator && coordinate.compensator_part != CompensatorPart::kKc;
}

std::vector<int> HeldSpring(const ParameterSet& parameters) {
  std::vector<int> held;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    const bool may_be_off =
        coordinate.kind == CoordinateKind::kCompensator && coordinate.compensator_part != CompensatorPart::kL;
    if (may_be_off && !coordinate.estimated()) held.push_back(i);
  }
  return held;
}

double TypicalSpringError(const ParameterSet& parameters, int coordinate) {
  const std::optional<CompensatorPart> part = parameters.coordinates()[coordinate].compensator_part;
  const bool is_anchor = part == CompensatorPart::kAx || part == CompensatorPart::kAy;
  return is_anchor ? kTypicalAnchorError : kTypicalSpringShare * std::abs(parameters.Value(coordinate));
}

void FreeSpring(bool rate_alone, double prior_scale, ParameterSet* parameters) {
  for (const int i : HeldSpring(*parameters)) {
    const double typical = TypicalSpringError(*parameters, i);
    Coordinate& coordinate = parameters->coordinate(i);
    if (!(typical > 0.0) || (rate_alone && coordinate.compensator_part != CompensatorPart::kKc)) continue;
    coordinate.free = true;
    coordinate.held = false;
    coordinate.prior_value = parameters->Value(i);
    coordinate.prior_sigma = coordinate.effect_prior = prior_scale * typical;
  }
}

std::vector<int> ComplianceCoordinates(const ParameterSet& parameters, const std::string& joint) {
  std::vector<int> nodes;
  for (int i = 0; i < parameters.num_coordinates(); ++i) {
    const Coordinate& coordinate = parameters.coordinates()[i];
    if (coordinate.kind != CoordinateKind::kCompliance) continue;
    const std::string name = NameWithinKind(coordinate.name);  // A2, or A2@-90 of a table
    if (name == joint || name.rfind(joint + '@', 0) == 0) nodes.push_back(i);
  }
  return nodes;
}

double ComplianceOf(const ParameterSet& parameters, const std::string& joint) {
  const std::vector<int> nodes = ComplianceCoordinates(parameters, joint);
  double sum = 0.0;
  for (const int i : nodes) sum += parameters.Value(i);
  return nodes.empty() ? 0.0 : sum / static_cast<double>(nodes.size());
}

EffectSpec ComplianceEffectOf(const std::string& joint) { return {JointComplianceEffect().name, joint, {}, {}}; }

std::vector<EffectSpec> CompensatorShapes(const std::string& joint) {
  std::vector<EffectSpec> shapes;
  for (const double ratio : kRatios) {
    for (int d = 0; d < kAnchorDirections; ++d) {
      shapes.push_back(ShapeOf(joint, ratio, 2.0 * kPi * d / kAnchorDirections));
    }
  }
  return shapes;
}

// tau(rho, ln(a / L), alpha) with s0 = rho a, to first order:  tau at rho = 0.65, then its derivative by each times the
// prior standard deviation of it.
Eigen::MatrixXd SpringColumns(const EffectSpec& shape, const Eigen::MatrixX2d& wave) {
  const auto usual = [&](double ratio, double alpha) -> Eigen::VectorXd {
    const EffectSpec near = ShapeOf(shape.target, ratio, alpha);
    const Eigen::MatrixX2d per_rate = TorquesPerRate(near, wave);
    return per_rate.col(0) + kUsualRest * ratio * kLever * per_rate.col(1);
  };
  const double a_x = shape.values[1], a_y = shape.values[2];
  const double a = std::hypot(a_x, a_y), ratio = a / kLever, alpha = std::atan2(a_x, a_y);
  constexpr double kStep = 1e-4;  // of a derivative: off by as much of itself
  Eigen::MatrixXd columns(wave.rows(), 4);
  columns << usual(ratio, alpha), kRestDeviation * a * TorquesPerRate(shape, wave).col(1),
      kDirectionDeviation / kStep * (usual(ratio, alpha + kStep) - usual(ratio, alpha)),
      kRatioDeviation / kStep * (usual(ratio * (1.0 + kStep), alpha) - usual(ratio, alpha));
  return columns;
}

Eigen::VectorXd SpringTorques(const ParameterSet& parameters, const Eigen::VectorXd& angles) {
  const auto value = [&](CompensatorPart part) { return parameters.Value(parameters.FindCoordinate(part)); };
  const CompensatorParameters<double> spring{value(CompensatorPart::kL), value(CompensatorPart::kAx),
                                             value(CompensatorPart::kAy), value(CompensatorPart::kS0),
                                             value(CompensatorPart::kKc)};
  return angles.unaryExpr([&](double q) { return CompensatorTorque(spring, std::cos(q), std::sin(q)); });
}

double SpringShares::Of(const Eigen::VectorXd& torques) const {
  const double size = torques.norm() * of_weight.norm();
  const double cosine = size > 0.0 ? torques.dot(of_weight) / size : 0.0;
  return elsewhere + (cosine < 0.0 ? per_cosine * cosine * cosine : 0.0);
}

void SeedSpring(const Eigen::VectorXd& angles, const Eigen::VectorXd& torques, EffectSpec* shape) {
  const Eigen::Vector2d rates = TorquesPerRate(*shape, Wave(angles)).colPivHouseholderQr().solve(torques);
  std::vector<double>& p = shape->values;
  const double longest = 2.0 * std::hypot(p[1], p[2]) + 2.0 * p[0];
  const double s0 = rates[0] > 0.0 ? rates[1] / rates[0] : -1.0;
  p[3] = std::min(std::max(s0, 0.5 * p[0]), longest);
  p[4] = std::max(rates[0], kLeastRate);
}

// a and L are alike in the torque: the longer one is what the rest length is in units of.
double LogPriorOfSpring(const ParameterSet& parameters) {
  const auto value = [&](CompensatorPart part) { return parameters.Value(parameters.FindCoordinate(part)); };
  const double a = std::hypot(value(CompensatorPart::kAx), value(CompensatorPart::kAy));
  const double longer = std::max(a, value(CompensatorPart::kL));
  if (std::abs(a - value(CompensatorPart::kL)) < kShortest * longer) return -std::numeric_limits<double>::infinity();
  const double x = (value(CompensatorPart::kS0) / longer - kUsualRest) / kRestDeviation;
  return -0.5 * x * x - 0.5 * std::log(2.0 * kPi) + std::log(kPi * (1.0 + x * x));
}

void BoundCompensatorShape(bool keep, ParameterSet* parameters) {
  const auto value = [&](CompensatorPart part) { return parameters->Value(parameters->FindCoordinate(part)); };
  const auto prior = [&](CompensatorPart part, double about, double sigma) {
    const int i = parameters->FindCoordinate(part);
    if (i < 0 || !parameters->coordinates()[i].free) return;
    parameters->coordinate(i).prior_value = about;
    parameters->coordinate(i).prior_sigma = parameters->coordinate(i).effect_prior = sigma;
  };
  if (!keep) {
    prior(CompensatorPart::kAx, 0.0, kAnchorReach);
    prior(CompensatorPart::kAy, 0.0, kAnchorReach);
    prior(CompensatorPart::kS0, kSpringRest, kSpringRest);
    return;
  }
  const double a_x = value(CompensatorPart::kAx), a_y = value(CompensatorPart::kAy), a = std::hypot(a_x, a_y);
  prior(CompensatorPart::kAx, a_x, kKeptWithin * a);
  prior(CompensatorPart::kAy, a_y, kKeptWithin * a);
  prior(CompensatorPart::kS0, kUsualRest * a, kRestDeviation * a);
}

}  // namespace sagitta
