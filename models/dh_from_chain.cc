#include "models/dh_from_chain.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "models/constants.h"
#include "models/kinematics.h"
#include "models/random_bits.h"

namespace sagitta {
namespace {

constexpr double kParallel = 3.0 * kDegree;
constexpr double kExactlyParallel = 1e-10;  // rad: nearer, the common normal is rounding
constexpr double kZero = 1e-12;             // m, rad: rounding of a chain of poses
constexpr double kLengthPrior = 5e-3, kAnglePrior = 5e-3;
constexpr double kToolReach = 0.1;  // m
constexpr int kPoses = 400, kClimbs = 12;

struct Line {
  Vector3<double> point, direction;
};

Line AxisLine(const Chain& chain, const std::vector<Pose<double>>& frames, int joint) {
  const int e = chain.JointTransform(joint);
  const ElementaryTransform& transform = chain.transforms[e];
  return {frames[e].translation, transform.sign * frames[e].rotation.col(static_cast<int>(transform.axis))};
}

Line Seen(const Pose<double>& from, const Line& line) {
  return {from.rotation.transpose() * (line.point - from.translation), from.rotation.transpose() * line.direction};
}

// Nothing but rounding counts as 0.
double Clean(double value) { return std::abs(value) < kZero ? 0.0 : value; }

// Turns the link's x axis round where theta would be beyond a quarter turn.
void KeepThetaSmall(DhLink* link) {
  if (link->theta > -0.5 * kPi + kZero && link->theta <= 0.5 * kPi + kZero) return;
  link->theta += link->theta > 0.0 ? -kPi : kPi;
  link->a = -link->a;
}

// Onto the line `next`, given in the frame whose z is the joint's axis.
DhLink LinkOnto(const Line& next, double parallel) {
  DhLink link;
  const Vector3<double>& v = next.direction;
  const double sine = v.head<2>().norm();
  if (sine > std::sin(parallel)) {
    // The common normal x: d where it leaves z, a its length.
    const Vector3<double> x = Vector3<double>::UnitZ().cross(v) / sine;
    const double along = -next.point.head<2>().dot(v.head<2>()) / (sine * sine);
    const Vector3<double> foot = next.point + along * v;
    link.theta = std::atan2(x.y(), x.x());
    link.a = Clean(foot.dot(x));
    link.d = Clean(foot.z());
    KeepThetaSmall(&link);
  } else {
    const Vector3<double> crossing = next.point - next.point.z() / v.z() * v;
    link.a = Clean(crossing.head<2>().norm());
    if (link.a > 0.0) link.theta = std::atan2(crossing.y(), crossing.x());
    KeepThetaSmall(&link);
  }
  link.theta = Clean(link.theta);
  // v = Rz(theta) Rx(alpha) Ry(beta) z, and Rx Ry z = (sin b, -sin a cos b, cos a cos b).
  const Vector3<double> seen = Eigen::AngleAxisd(-link.theta, Vector3<double>::UnitZ()) * v;
  link.alpha = Clean(std::atan2(-seen.y(), seen.z()));
  link.beta = Clean(std::atan2(seen.x(), seen.tail<2>().norm()));
  return link;
}

Pose<double> LinkPose(const DhLink& link) {
  Pose<double> pose;
  RotateInPlace(Axis::kZ, link.theta, &pose.rotation);
  pose.translation = Vector3<double>(0, 0, link.d) + link.a * pose.rotation.col(0);
  RotateInPlace(Axis::kX, link.alpha, &pose.rotation);
  RotateInPlace(Axis::kY, link.beta, &pose.rotation);
  return pose;
}

// The last link as far as its four parameters go; the rest is the flange's pose.
void CloseTable(const Pose<double>& flange, int joint, DhTable* table) {
  DhLink link;
  const Vector3<double> x = flange.rotation.col(0);
  if (std::abs(x.z()) < kZero) {
    link.theta = Clean(std::atan2(x.y(), x.x()));
    link.a = Clean(flange.translation.dot(x));
    link.d = Clean(flange.translation.z());
    const Vector3<double> z = Eigen::AngleAxisd(-link.theta, Vector3<double>::UnitZ()) * flange.rotation.col(2);
    link.alpha = Clean(std::atan2(-z.y(), z.z()));
  }
  link.joint = joint;
  table->links.push_back(link);
  const Pose<double> reached = LinkPose(link);
  const Vector3<double> rest = reached.rotation.transpose() * (flange.translation - reached.translation);
  table->flange_xyz = rest.norm() < kZero ? Vector3<double>::Zero() : Vector3<double>(rest.unaryExpr(&Clean));
  const Matrix3<double> turn = reached.rotation.transpose() * flange.rotation;
  if ((turn - Matrix3<double>::Identity()).norm() > kZero) table->flange_rpy = RpyFromRotation(turn).unaryExpr(&Clean);
}

std::vector<Pose<double>> FramesAtZero(const Chain& chain) {
  return NominalFrames(chain, Eigen::VectorXd::Zero(chain.num_joints()));
}

// The first joint's positive motion is about (along) the base's -z.
bool CountsTheOtherWay(const Line& first) { return (first.direction + Vector3<double>::UnitZ()).norm() < kZero; }

// frames: of the chain at joint values 0; parallel: rad, within which axes count as parallel and have beta.
std::optional<DhTable> StandardTable(const Chain& chain, const std::vector<Pose<double>>& frames, double parallel,
                                     std::string* why_not) {
  const Line first = AxisLine(chain, frames, 0);
  const bool slides = chain.joints[0].type == JointType::kPrismatic;
  const double off = slides ? 0.0 : first.point.head<2>().norm();
  if (CountsTheOtherWay(first) && off <= kZero) {
    *why_not = "joint '" + chain.joints[0].name + "' moves " + (slides ? "along" : "about") +
               " the z axis of the base and counts the other way, and a table begins with a joint that counts along z";
    return std::nullopt;
  }
  if ((first.direction - Vector3<double>::UnitZ()).norm() > kZero || off > kZero) {
    *why_not =
        "joint '" + chain.joints[0].name + "' does not move about the z axis of the base, where a DH table begins";
    return std::nullopt;
  }
  DhTable table;
  table.convention = DhConvention::kStandard;
  Pose<double> here;
  for (int j = 0; j + 1 < chain.num_joints(); ++j) {
    Line next = AxisLine(chain, frames, j + 1);
    if (chain.joints[j + 1].type == JointType::kPrismatic) next.point = here.translation;  // a slide has no place
    DhLink link = LinkOnto(Seen(here, next), parallel);
    link.joint = j;
    table.links.push_back(link);
    here = Product(here, LinkPose(link));
  }
  const Pose<double>& flange = frames.back();
  const Pose<double> flange_here{here.rotation.transpose() * flange.rotation,
                                 here.rotation.transpose() * (flange.translation - here.translation)};
  CloseTable(flange_here, chain.num_joints() - 1, &table);
  return table;
}

Pose<double> FlangePose(const DhTable& table) {
  Pose<double> pose;
  for (int i = 2; i >= 0; --i) RotateInPlace(static_cast<Axis>(i), table.flange_rpy[i], &pose.rotation);
  pose.translation = table.flange_xyz;
  return pose;
}

DhTable ModifiedFromStandard(const DhTable& standard) {
  DhTable table = standard;
  table.convention = DhConvention::kModified;
  for (size_t i = 0; i < table.links.size(); ++i) {
    const DhLink before = i == 0 ? DhLink() : standard.links[i - 1];
    table.links[i].a = before.a;
    table.links[i].alpha = before.alpha;
    table.links[i].beta = before.beta;
  }
  DhLink last = standard.links.back();
  last.theta = last.d = 0.0;
  const Pose<double> flange = Product(LinkPose(last), FlangePose(standard));
  table.flange_xyz = flange.translation;
  table.flange_rpy = RpyFromRotation(flange.rotation).unaryExpr(&Clean);
  return table;
}

std::optional<DhTable> StandardFromModified(const DhTable& modified, std::string* why_not) {
  const DhLink& first = modified.links.front();
  if (first.a != 0.0 || first.alpha != 0.0 || first.beta != 0.0) {
    *why_not = "its first row has a, alpha or beta, and a standard table begins with the joint";
    return std::nullopt;
  }
  DhTable table = modified;
  table.convention = DhConvention::kStandard;
  for (size_t i = 0; i < table.links.size(); ++i) {
    const bool is_last = i + 1 == table.links.size();
    table.links[i].a = is_last ? 0.0 : modified.links[i + 1].a;
    table.links[i].alpha = is_last ? 0.0 : modified.links[i + 1].alpha;
    table.links[i].beta = is_last ? 0.0 : modified.links[i + 1].beta;
  }
  return table;
}

// The four parameters of a row, and the scale of what they may change by.
double* Entry(DhTable* table, int i) {
  DhLink& link = table->links[i / 4];
  return i % 4 == 0 ? &link.a : i % 4 == 1 ? &link.d : i % 4 == 2 ? &link.alpha : &link.theta;
}
double PriorOf(int i) { return i % 4 < 2 ? kLengthPrior : kAnglePrior; }

struct JointRange {
  double low, high;  // rad or m
};

JointRange RangeOf(const Joint& joint) {
  const double reach = joint.type == JointType::kRevolute ? kPi : 1.0;
  return {joint.min.value_or(-reach), joint.max.value_or(reach)};
}

std::vector<Eigen::VectorXd> RandomPoses(const Chain& chain) {
  std::mt19937_64 random(1955);
  std::vector<Eigen::VectorXd> poses(kPoses, Eigen::VectorXd(chain.num_joints()));
  for (Eigen::VectorXd& q : poses) {
    for (int j = 0; j < q.size(); ++j) {
      const JointRange range = RangeOf(chain.joints[j]);
      q[j] = range.low + (range.high - range.low) * UnitNumber(random());
    }
  }
  return poses;
}

double FlangesApart(const Chain& a, const Chain& b, const Eigen::VectorXd& q) {
  return (NominalFrames(a, q).back().translation - NominalFrames(b, q).back().translation).norm();
}

// From a pose uphill, one joint after the other within its range, by steps that are halved where none leads higher.
double LargestNear(const Chain& a, const Chain& b, Eigen::VectorXd q) {
  double largest = FlangesApart(a, b, q);
  for (double step = 0.1; step > 1e-3;) {  // shares of the range
    bool is_higher = false;
    for (int j = 0; j < q.size(); ++j) {
      const JointRange range = RangeOf(a.joints[j]);
      for (const double by : {-step, step}) {
        Eigen::VectorXd tried = q;
        tried[j] = std::clamp(q[j] + by * (range.high - range.low), range.low, range.high);
        const double apart = FlangesApart(a, b, tried);
        if (!(apart > largest)) continue;
        largest = apart;
        q = tried;
        is_higher = true;
      }
    }
    if (!is_higher) step *= 0.5;
  }
  return largest;
}

// The largest distance of the flanges in the joints' range: uphill from the worst of these poses; by_pose: theirs.
double LargestApart(const Chain& a, const Chain& b, const std::vector<Eigen::VectorXd>& poses,
                    const std::vector<double>& by_pose) {
  std::vector<size_t> order(poses.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](size_t i, size_t k) { return by_pose[i] > by_pose[k]; });
  double largest = 0.0;
  for (size_t i = 0; i < std::min<size_t>(order.size(), kClimbs); ++i) {
    largest = std::max(largest, LargestNear(a, b, poses[order[i]]));
  }
  return largest;
}

// Flange and two points away from it, all poses, m.
Eigen::VectorXd Points(const Chain& chain, const std::vector<Eigen::VectorXd>& poses) {
  Eigen::VectorXd points(9 * poses.size());
  for (size_t p = 0; p < poses.size(); ++p) {
    const Pose<double> flange = NominalFrames(chain, poses[p]).back();
    points.segment<3>(9 * p) = flange.translation;
    points.segment<3>(9 * p + 3) = flange * Vector3<double>(kToolReach, 0, 0);
    points.segment<3>(9 * p + 6) = flange * Vector3<double>(0, kToolReach, 0);
  }
  return points;
}

}  // namespace

std::optional<DhTable> DhTableFromChain(const Chain& chain, DhConvention convention, std::string* why_not) {
  std::vector<Pose<double>> frames = FramesAtZero(chain);
  // The first row of a modified table turns the base over before its joint.
  const bool turned = convention == DhConvention::kModified && CountsTheOtherWay(AxisLine(chain, frames, 0));
  if (turned) {
    const Pose<double> over{Eigen::Vector3d(1, -1, -1).asDiagonal(), Vector3<double>::Zero()};
    for (Pose<double>& frame : frames) frame = Product(over, frame);
  }
  const std::optional<DhTable> standard = StandardTable(chain, frames, kParallel, why_not);
  if (!standard) return std::nullopt;
  switch (convention) {
    case DhConvention::kStandard:
      return standard;
    case DhConvention::kModified: {
      DhTable modified = ModifiedFromStandard(*standard);
      if (turned) modified.links.front().alpha = kPi;
      return modified;
    }
  }
  return std::nullopt;
}

std::optional<DhTable> ExactPlainTable(const Chain& chain, std::string* why_not) {
  return StandardTable(chain, FramesAtZero(chain), kExactlyParallel, why_not);
}

std::optional<DhTable> InConvention(const DhTable& table, DhConvention convention, std::string* why_not) {
  if (table.convention == convention) return table;
  switch (convention) {
    case DhConvention::kStandard:
      return StandardFromModified(table, why_not);
    case DhConvention::kModified:
      return ModifiedFromStandard(table);
  }
  return std::nullopt;
}

PlainDhFit FitPlainDh(const Chain& chain, const DhTable& with_beta) {
  const auto chain_of = [&chain](const DhTable& table) {
    return ChainFromDhTable(chain.joints, chain.couplings, table);
  };
  const std::vector<Eigen::VectorXd> poses = RandomPoses(chain);
  const Eigen::VectorXd target = Points(chain_of(with_beta), poses);
  PlainDhFit fit{with_beta};
  for (DhLink& link : fit.table.links) link.beta = 0.0;
  DhTable start = fit.table;
  const int n = 4 * static_cast<int>(fit.table.links.size());
  // Nearly linear in errors of mrad: a few Gauss-Newton steps, derivatives by central differences. A change by one
  // sigma of the prior has to be worth 0.01 mm (RMS over all coordinates).
  constexpr double kStep = 1e-6;
  const double prior_weight = 1e-5 * std::sqrt(static_cast<double>(target.size()));
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::MatrixXd jacobian(target.size() + n, n);
    Eigen::VectorXd residual(target.size() + n);
    residual.head(target.size()) = Points(chain_of(fit.table), poses) - target;
    jacobian.bottomRows(n).setZero();
    for (int i = 0; i < n; ++i) {
      DhTable plus = fit.table, minus = fit.table;
      *Entry(&plus, i) += kStep;
      *Entry(&minus, i) -= kStep;
      jacobian.col(i).head(target.size()) =
          (Points(chain_of(plus), poses) - Points(chain_of(minus), poses)) / (2 * kStep);
      jacobian(target.size() + i, i) = prior_weight / PriorOf(i);
      residual[target.size() + i] = prior_weight * (*Entry(&fit.table, i) - *Entry(&start, i)) / PriorOf(i);
    }
    const Eigen::VectorXd step = jacobian.householderQr().solve(residual);
    for (int i = 0; i < n; ++i) *Entry(&fit.table, i) -= step[i];
    if (step.norm() < 1e-12) break;
  }
  const Eigen::VectorXd off = Points(chain_of(fit.table), poses) - target;
  std::vector<double> by_pose;
  double sum = 0.0;
  for (size_t p = 0; p < poses.size(); ++p) {
    by_pose.push_back(off.segment<3>(9 * p).norm());
    sum += by_pose.back() * by_pose.back();
  }
  fit.rms = std::sqrt(sum / poses.size());
  fit.max = LargestApart(chain_of(fit.table), chain_of(with_beta), poses, by_pose);
  for (int i = 0; i < n; ++i) {
    if (i % 4 >= 2) continue;
    fit.largest_length_change =
        std::max(fit.largest_length_change, std::abs(*Entry(&fit.table, i) - *Entry(&start, i)));
  }
  return fit;
}

}  // namespace sagitta
