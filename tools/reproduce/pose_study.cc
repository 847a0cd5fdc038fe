#include "tools/reproduce/pose_study.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "estimator/alignment/pose_registration.h"
#include "models/constants.h"
#include "models/forward_model.h"
#include "problems/range.h"
#include "tools/reproduce/data.h"

namespace sagitta {
namespace {

constexpr double kWorstCondition = 1e6;  // sets beyond it do not determine the parameters

// The pose rows B (6 per configuration) and their information C^-1 = G'G at sigma 1.
struct PoseRows {
  Eigen::MatrixXd jacobian;
  std::vector<Eigen::Matrix<double, 6, 6>> information;
};

// Turning rates (rad) of the angles of R = Rz(a) Ry(b) Rx(c): columns z, Rz y, Rz Ry x.
Matrix3<double> EulerRates(const Matrix3<double>& rotation) {
  const Vector3<double> z = Vector3<double>::UnitZ(), x = rotation.col(0);
  Matrix3<double> rates;
  rates << x, z.cross(x).normalized(), z;  // order c, b, a
  return rates;
}

PoseRows EvaluatePoses(const ForwardModel& model, const std::vector<Eigen::VectorXd>& configurations,
                       const MarkerLayout& layout, OrientationRows orientation, Eigen::MatrixXd* marker_rows) {
  const int n = static_cast<int>(layout.points.size());
  const std::vector<double> theta(model.num_parameters(), 0.0);
  std::vector<int> active(model.num_parameters());
  for (size_t i = 0; i < active.size(); ++i) active[i] = static_cast<int>(i);
  // The flange origin rides along as the last point.
  std::vector<MarkerInFrame> points;
  for (const Vector3<double>& point : layout.points) points.push_back({model.chain().FlangeFrame(), point});
  points.push_back({model.chain().FlangeFrame(), Vector3<double>::Zero()});
  PoseRows rows{Eigen::MatrixXd(6 * configurations.size(), active.size()), {}};
  marker_rows->resize(3 * n * configurations.size(), active.size());
  std::vector<PointPrediction> predictions;
  for (size_t k = 0; k < configurations.size(); ++k) {
    model.Predict(configurations[k], theta.data(), active, Pose<double>(), points, &predictions);
    Eigen::Matrix3Xd seen(3, n);
    for (int i = 0; i < n; ++i) {
      seen.col(i) = predictions[i].point;
      marker_rows->middleRows(3 * (n * k + i), 3) = predictions[i].d_theta;
    }
    Eigen::MatrixXd rigid = RigidColumns(seen, predictions[n].point);
    if (orientation == OrientationRows::kEulerAngles) rigid.rightCols<3>() *= EulerRates(predictions[n].d_marker);
    rows.jacobian.middleRows(6 * k, 6) = rigid.householderQr().solve(marker_rows->middleRows(3 * n * k, 3 * n));
    rows.information.push_back(rigid.transpose() * rigid);
  }
  return rows;
}

// Standard deviations at sigma 1 of least squares on the poses, W = (1, w^2).
Eigen::VectorXd WeightedSigmas(const PoseRows& rows, double w) {
  const Vector6 weight = (Vector6() << 1, 1, 1, w * w, w * w, w * w).finished();
  const int n = static_cast<int>(rows.jacobian.cols());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n), middle = Eigen::MatrixXd::Zero(n, n);
  for (size_t k = 0; k < rows.information.size(); ++k) {
    const Eigen::MatrixXd weighted = weight.asDiagonal() * rows.jacobian.middleRows(6 * k, 6);
    normal += rows.jacobian.middleRows(6 * k, 6).transpose() * weighted;
    middle += weighted.transpose() * rows.information[k].inverse() * weighted;
  }
  const Eigen::MatrixXd inverse = normal.inverse();
  return (inverse * middle * inverse).diagonal().cwiseSqrt();
}

// The same with W = C^-1.
Eigen::VectorXd PropagatedSigmas(const PoseRows& rows) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(rows.jacobian.cols(), rows.jacobian.cols());
  for (size_t k = 0; k < rows.information.size(); ++k) {
    const auto pose = rows.jacobian.middleRows(6 * k, 6);
    normal += pose.transpose() * rows.information[k] * pose;
  }
  return normal.inverse().diagonal().cwiseSqrt();
}

bool Determines(const Eigen::MatrixXd& marker_rows) {
  const Eigen::VectorXd norms = marker_rows.colwise().norm();
  if (!(norms.minCoeff() > 0.0)) return false;
  const Eigen::MatrixXd scaled = marker_rows * norms.cwiseInverse().asDiagonal();
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  return singular[0] < kWorstCondition * singular[singular.size() - 1];
}

double Quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(std::lround(p * (values.size() - 1)))];
}

// Factors of all sets: [weight][parameter][set].
using Factors = std::vector<std::vector<std::vector<double>>>;

PoseStudyRow Summarise(const std::string& layout, double weight, const std::vector<std::vector<double>>& factors,
                       double largest_gap) {
  PoseStudyRow row;
  row.layout = layout;
  row.weight = weight;
  row.largest_gap = largest_gap;
  row.smallest = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& of_parameter : factors) {
    row.median.push_back(Quantile(of_parameter, 0.5));
    row.low.push_back(Quantile(of_parameter, 0.1));
    row.high.push_back(Quantile(of_parameter, 0.9));
    for (const double factor : of_parameter) row.smallest = std::min(row.smallest, factor);
  }
  return row;
}

}  // namespace

MarkerLayout DiscLayout(const std::string& name, double radius, double ahead) {
  MarkerLayout layout{name, {}};
  for (int i = 0; i < 3; ++i) {
    const double angle = 2.0 * kPi * i / 3.0;
    layout.points.emplace_back(ahead, radius * std::cos(angle), radius * std::sin(angle));
  }
  return layout;
}

void CheckOptions(const PoseStudyOptions& options) {
  CheckIn(allowed::kPoses, options.configurations, "PoseStudyOptions.configurations");
  CheckIn(allowed::kTrials, options.sets, "PoseStudyOptions.sets");
  for (const double w : options.weights) CheckIn(allowed::kFactor, w, "PoseStudyOptions.weights");
}

PoseStudy StudyPoses(const Robot& robot, const std::vector<MarkerLayout>& layouts, const PoseStudyOptions& options) {
  CheckOptions(options);
  const ForwardModel model(robot.chain);
  PoseStudy study;
  for (const ModelParameter& parameter : model.parameters()) {
    study.parameters.push_back(model.chain().transforms[parameter.index].error);
  }
  for (const MarkerLayout& layout : layouts) {
    std::mt19937_64 random(options.seed);  // the same sets for every layout
    Factors factors(options.weights.size(), std::vector<std::vector<double>>(study.parameters.size()));
    double largest_gap = 0.0;
    study.sets = 0;
    for (int set = 0; set < options.sets; ++set) {
      Eigen::MatrixXd marker_rows;
      const PoseRows poses = EvaluatePoses(model, DrawConfigurations(model.chain(), options.configurations, &random),
                                           layout, options.orientation, &marker_rows);
      if (!Determines(marker_rows)) continue;
      ++study.sets;
      const Eigen::VectorXd markers = (marker_rows.transpose() * marker_rows).inverse().diagonal().cwiseSqrt();
      const Eigen::VectorXd propagated = PropagatedSigmas(poses);
      largest_gap = std::max(largest_gap, (propagated.cwiseQuotient(markers).array() - 1.0).abs().maxCoeff());
      for (size_t w = 0; w < options.weights.size(); ++w) {
        const Eigen::VectorXd ratio = WeightedSigmas(poses, options.weights[w]).cwiseQuotient(markers);
        for (int p = 0; p < ratio.size(); ++p) factors[w][p].push_back(ratio[p]);
      }
    }
    for (size_t w = 0; w < options.weights.size(); ++w) {
      study.rows.push_back(Summarise(layout.name, options.weights[w], factors[w], largest_gap));
    }
  }
  return study;
}

}  // namespace sagitta
