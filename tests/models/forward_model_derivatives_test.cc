// Predict's geometric derivatives against Jets through the templated chain and
// against Ridders differences, for many kinds of arms in three regimes.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <numeric>

#include "models/forward_model.h"
#include "tests/support/arms.h"
#include "tests/support/kr270.h"
#include "tests/support/ridders.h"

namespace sagitta::forward_model_derivatives_test {
namespace {

using test::RandomNumbers;

constexpr int kMaxUnknowns = 64;  // 6 of the base, 3 of the marker, the rest theta
using Jet = ceres::Jet<double, kMaxUnknowns>;

struct Arm {
  std::string name;
  Chain chain;
  std::vector<Eigen::VectorXd> poses;
};

void PrintTo(const Arm& arm, std::ostream* out) { *out << arm.name; }

std::vector<Arm> Arms() {
  RandomNumbers random(20240501);
  std::vector<Arm> arms;
  arms.push_back({"Kr270", test::Kr270Chain(), {}});
  arms.push_back({"Ur5Standard", test::DhArm(DhConvention::kStandard, test::Ur5Rows()), {}});
  arms.push_back({"PumaModified", test::DhArm(DhConvention::kModified, test::PumaModifiedRows()), {}});
  arms.push_back({"Iiwa7R", test::DhArm(DhConvention::kStandard, test::IiwaRows()), {}});
  arms.push_back({"PrismaticFirst", test::DhArm(DhConvention::kStandard, test::TrackRows()), {}});
  arms.push_back({"PrismaticFirstModified", test::DhArm(DhConvention::kModified, test::TrackRows()), {}});
  arms.push_back({"Scara", test::DhArm(DhConvention::kStandard, test::ScaraRows()), {}});
  for (int i = 0; i < 6; ++i) {
    const int joints = std::vector<int>{6, 6, 7, 7, 3, 1}[i];
    arms.push_back({"Random" + std::to_string(i), test::RandomArm(joints, i % 2 == 1, &random), {}});
  }
  for (Arm& arm : arms) {
    for (int i = 0; i < 4; ++i) arm.poses.push_back(test::RandomJointValues(arm.chain, &random));
    arm.poses.push_back(Eigen::VectorXd::Zero(arm.chain.num_joints()));
  }
  // Elbow stretched and wrist aligned, exactly and nearly.
  for (const double off : {0.0, 1e-9, 1e-6}) {
    Eigen::VectorXd q = arms[1].poses[0];
    q[2] = off;
    q[4] = off;
    arms[1].poses.push_back(q);
    arms[0].poses.push_back(q);
  }
  return arms;
}

// theta = 0, tiny, and of the size of real errors and beyond.
std::vector<double> Theta(int n, int regime, RandomNumbers* random) {
  const double size = std::vector<double>{0.0, 1e-8, 1e-2}[regime];
  std::vector<double> theta(n);
  for (double& value : theta) value = random->Uniform(-size, size);
  return theta;
}

Pose<double> RandomPose(RandomNumbers* random) {
  Pose<double> pose;
  pose.rotation = RotationFromVector<double>(random->Vector(1.7));
  pose.translation = random->Vector(3.0);
  return pose;
}

// exp(delta) R * point_base + t + dt of any scalar; the definition Predict has to meet.
template <typename T>
Vector3<T> PointInStation(const ForwardModel& model, const Eigen::VectorXd& q, const Pose<double>& base_in_station,
                          int frame, const Vector3<T>& dt, const Vector3<T>& delta, const Vector3<T>& marker,
                          const std::vector<T>& theta) {
  const Vector3<T> in_base = model.PointInBase(q, theta.data(), frame, marker);
  const Vector3<T> arm = base_in_station.rotation.cast<T>() * in_base;
  return RotationFromVector(delta) * arm + base_in_station.translation.cast<T>() + dt;
}

// Relative to the column, or to 1 mm/unit where a column (nearly) vanishes.
void ExpectColumnNear(const Vector3<double>& ours, const Vector3<double>& expected, double tolerance,
                      const std::string& what) {
  EXPECT_LE((ours - expected).norm(), tolerance * std::max(expected.norm(), 1e-3)) << what;
}

class ForwardModelDerivatives : public ::testing::TestWithParam<std::tuple<Arm, int>> {
 protected:
  // Calls check(model, q, base, marker, theta, prediction) for every pose and
  // for markers on the flange, on links and on the base.
  template <typename Check>
  void ForEveryShot(const Check& check) {
    const auto& [arm, regime] = GetParam();
    const ForwardModel model(arm.chain);
    ASSERT_LE(model.num_parameters() + 9, kMaxUnknowns);
    ASSERT_EQ(arm.chain.Defect(), "");
    RandomNumbers random(77 + regime);
    std::vector<int> all(model.num_parameters());
    std::iota(all.begin(), all.end(), 0);
    for (const Eigen::VectorXd& q : arm.poses) {
      const std::vector<double> theta = Theta(model.num_parameters(), regime, &random);
      const Pose<double> base_in_station = RandomPose(&random);
      std::vector<MarkerInFrame> markers;
      for (const int frame : {arm.chain.FlangeFrame(), arm.chain.FrameAfterJoint(random.Index(arm.chain.num_joints())),
                              random.Index(arm.chain.num_transforms() + 1), arm.chain.BaseFrame()}) {
        markers.push_back({frame, random.Vector(0.4)});
      }
      std::vector<PointPrediction> predictions;
      model.Predict(q, theta.data(), all, base_in_station, markers, &predictions);
      ASSERT_EQ(predictions.size(), markers.size());
      for (size_t m = 0; m < markers.size(); ++m) {
        check(model, q, base_in_station, markers[m], theta, predictions[m]);
      }
    }
  }
};

TEST_P(ForwardModelDerivatives, EqualJets) {
  ForEveryShot([](const ForwardModel& model, const Eigen::VectorXd& q, const Pose<double>& base_in_station,
                  const MarkerInFrame& marker, const std::vector<double>& theta, const PointPrediction& prediction) {
    Vector3<Jet> dt, delta, point;
    for (int i = 0; i < 3; ++i) {
      dt[i] = Jet(0.0, i);
      delta[i] = Jet(0.0, 3 + i);
      point[i] = Jet(marker.point[i], 6 + i);
    }
    std::vector<Jet> jet_theta;
    for (size_t i = 0; i < theta.size(); ++i) jet_theta.emplace_back(theta[i], 9 + static_cast<int>(i));
    const Vector3<Jet> expected = PointInStation(model, q, base_in_station, marker.frame, dt, delta, point, jet_theta);
    const auto column = [&](int k) { return Vector3<double>(expected[0].v[k], expected[1].v[k], expected[2].v[k]); };
    EXPECT_LT((prediction.point - Vector3<double>(expected[0].a, expected[1].a, expected[2].a)).norm(), 1e-13);
    for (int i = 0; i < 3; ++i) {
      ExpectColumnNear(Vector3<double>::Unit(i), column(i), 1e-10, "translation");
      ExpectColumnNear(prediction.d_rotation.col(i), column(3 + i), 1e-10, "rotation");
      ExpectColumnNear(prediction.d_marker.col(i), column(6 + i), 1e-10, "marker");
    }
    ASSERT_EQ(prediction.d_theta.cols(), static_cast<int>(theta.size()));
    for (size_t i = 0; i < theta.size(); ++i) {
      ExpectColumnNear(prediction.d_theta.col(i), column(9 + i), 1e-10, model.parameters()[i].name);
    }
  });
}

TEST_P(ForwardModelDerivatives, EqualRiddersDifferences) {
  ForEveryShot([](const ForwardModel& model, const Eigen::VectorXd& q, const Pose<double>& base_in_station,
                  const MarkerInFrame& marker, const std::vector<double>& theta, const PointPrediction& prediction) {
    // All unknowns in one row: delta, marker, theta.
    Eigen::VectorXd unknowns(6 + theta.size());
    unknowns.head<3>().setZero();
    unknowns.segment<3>(3) = marker.point;
    for (size_t i = 0; i < theta.size(); ++i) unknowns[6 + i] = theta[i];
    const Vector3<double> no_shift = Vector3<double>::Zero();
    for (int k = 0; k < unknowns.size(); ++k) {
      const auto point_at = [&](double value) {
        Eigen::VectorXd moved = unknowns;
        moved[k] = value;
        const std::vector<double> moved_theta(moved.data() + 6, moved.data() + moved.size());
        return Eigen::VectorXd(PointInStation<double>(model, q, base_in_station, marker.frame, no_shift,
                                                      moved.head<3>(), moved.segment<3>(3), moved_theta));
      };
      const Vector3<double> expected = test::RiddersDerivative(point_at, unknowns[k], 0.05);
      const Vector3<double> ours = k < 3   ? Vector3<double>(prediction.d_rotation.col(k))
                                   : k < 6 ? Vector3<double>(prediction.d_marker.col(k - 3))
                                           : Vector3<double>(prediction.d_theta.col(k - 6));
      ExpectColumnNear(ours, expected, 1e-6, "unknown " + std::to_string(k));
    }
  });
}

std::string NameOf(const ::testing::TestParamInfo<std::tuple<Arm, int>>& info) {
  static const char* const regimes[] = {"Neutral", "Tiny", "Random"};
  return std::get<0>(info.param).name + regimes[std::get<1>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Arms, ForwardModelDerivatives,
                         ::testing::Combine(::testing::ValuesIn(Arms()), ::testing::Values(0, 1, 2)), NameOf);

TEST(ForwardModel, DifferentiatesByTheActiveParametersOnly) {
  const ForwardModel model(test::Kr270Chain());
  const std::vector<double> theta(18, 1e-3);
  Eigen::VectorXd q(6);
  q << 0.3, -1.2, 0.8, 1.0, -0.6, 2.0;
  const std::vector<MarkerInFrame> markers = {{model.chain().FlangeFrame(), {0.28, -0.02, -0.09}}};
  std::vector<int> all(18);
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int> some = {17, 3, 8};
  std::vector<PointPrediction> full, part, none;
  model.Predict(q, theta.data(), all, Pose<double>(), markers, &full);
  model.Predict(q, theta.data(), some, Pose<double>(), markers, &part);
  model.Predict(q, theta.data(), {}, Pose<double>(), markers, &none);
  ASSERT_EQ(part[0].d_theta.cols(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ((part[0].d_theta.col(i) - full[0].d_theta.col(some[i])).norm(), 0.0);
  EXPECT_EQ(none[0].d_theta.cols(), 0);
  EXPECT_EQ((none[0].point - full[0].point).norm(), 0.0);
}

// v = nominal + sign * (q + coupling + latent) + delta, FORMATS section 1.
TEST(ForwardModel, TransformValuesFollowTheSignAndCouplingRule) {
  Chain chain;
  chain.joints = test::Revolutes(3);
  chain.transforms = {test::OnJoint(Motion::kRotation, Axis::kZ, 0, "e1", 1.0, 0.5),
                      test::Translate(Axis::kX, 0.7, "e2"),
                      test::OnJoint(Motion::kRotation, Axis::kY, 1, "", -1.0, 0.25),
                      test::OnJoint(Motion::kRotation, Axis::kY, 2, "e3", -1.0)};
  chain.couplings = {{2, 1, 0.5}};
  const ForwardModel model(chain);
  const double theta[] = {0.01, 0.002, 0.03};
  const double latent[] = {1e-3, 2e-3, 4e-3};
  Eigen::VectorXd q(3);
  q << 0.1, 0.2, 0.4;
  const std::vector<double> values = model.TransformValues(q, theta, latent);
  ASSERT_EQ(values.size(), 4u);
  EXPECT_NEAR(values[0], 0.5 + 0.1 + 1e-3 + 0.01, 1e-15);
  EXPECT_NEAR(values[1], 0.702, 1e-15);
  EXPECT_NEAR(values[2], 0.25 - (0.2 + 2e-3), 1e-15);
  EXPECT_NEAR(values[3], -(0.4 + 0.5 * 0.2 + 4e-3) + 0.03, 1e-15);
}

}  // namespace
}  // namespace sagitta::forward_model_derivatives_test
