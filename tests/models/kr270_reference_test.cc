// Against kr270_reference.json, an independent computation (numpy): flange, the
// markers without load, and the 135 x 18 geometric Jacobian. It is in mm and rad.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "models/forward_model.h"
#include "tests/support/kr270.h"
#include "tests/support/paths.h"

namespace sagitta::kr270_reference_test {
namespace {

constexpr double kMm = 1e-3;

Vector3<double> VectorFrom(const nlohmann::json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

class Kr270Reference : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string path = test::SharedFolder() + "/reference/kr270_reference.json";
    std::ifstream file(path);
    if (!file) GTEST_SKIP() << "no " << path << ": the reference values are not part of this repository";
    reference_ = nlohmann::json::parse(file);
    base_in_station_.translation = kMm * VectorFrom(reference_["base_p"]);
    base_in_station_.rotation = RotationFromVector(VectorFrom(reference_["base_rotvec"]));
    for (const ModelParameter& parameter : model_.parameters()) {
      const double value = reference_["geo_mm_rad"][theta_.size()];
      theta_.push_back(parameter.quantity == Quantity::kLength ? kMm * value : value);
    }
    for (const nlohmann::json& point : reference_["tool"]) {
      markers_.push_back({model_.chain().FlangeFrame(), kMm * VectorFrom(point)});
    }
  }

  int num_configurations() const { return static_cast<int>(reference_["q_deg"].size()); }

  Eigen::VectorXd JointValues(int configuration) const {
    Eigen::VectorXd q(6);
    for (int j = 0; j < 6; ++j) q[j] = kDegree * reference_["q_deg"][configuration][j].get<double>();
    return q;
  }

  std::vector<PointPrediction> Predict(int configuration) const {
    std::vector<int> all(model_.num_parameters());
    std::iota(all.begin(), all.end(), 0);
    std::vector<PointPrediction> predictions;
    model_.Predict(JointValues(configuration), theta_.data(), all, base_in_station_, markers_, &predictions);
    return predictions;
  }

  const ForwardModel model_{test::Kr270Chain()};
  nlohmann::json reference_;
  Pose<double> base_in_station_;
  std::vector<double> theta_;
  std::vector<MarkerInFrame> markers_;
};

TEST_F(Kr270Reference, ErrorsStandInTheOrderOfTheTable) {
  ASSERT_EQ(model_.num_parameters(), 18);
  ASSERT_EQ(reference_["geo_names"].size(), 18u);
  for (int i = 0; i < 18; ++i) EXPECT_EQ(model_.parameters()[i].name, "geometry/" + test::Kr270Errors()[i]);
  EXPECT_EQ(model_.chain().Defect(), "");
}

TEST_F(Kr270Reference, FlangePose) {
  ASSERT_EQ(num_configurations(), 15);
  for (int c = 0; c < 15; ++c) {
    ChainState<double> state;
    EvaluateChain(model_.chain(), model_.TransformValues(JointValues(c), theta_.data()).data(), &state);
    const Pose<double>& flange_in_base = state.frames[model_.chain().FlangeFrame()];
    EXPECT_LT((flange_in_base.translation / kMm - VectorFrom(reference_["flange_p"][c])).norm(), 1e-9);
    for (int r = 0; r < 3; ++r) {
      const Vector3<double> row = flange_in_base.rotation.row(r);
      EXPECT_LT((row - VectorFrom(reference_["flange_R"][c][r])).norm(), 1e-12);
    }
  }
}

TEST_F(Kr270Reference, UnloadedMarkers) {
  for (int c = 0; c < num_configurations(); ++c) {
    const std::vector<PointPrediction> predictions = Predict(c);
    for (int m = 0; m < 3; ++m) {
      EXPECT_LT((predictions[m].point / kMm - VectorFrom(reference_["markers_unloaded"][c][m])).norm(), 1e-9)
          << "configuration " << c << ", marker " << m;
    }
  }
}

TEST_F(Kr270Reference, GeometricJacobian) {
  const nlohmann::json& expected = reference_["geo_jacobian_135x18_rowmajor_cfg_marker_xyz"];
  ASSERT_EQ(expected.size(), 135u);
  Eigen::MatrixXd ours(135, 18);
  Eigen::MatrixXd theirs(135, 18);
  for (int c = 0; c < num_configurations(); ++c) {
    const std::vector<PointPrediction> predictions = Predict(c);
    for (int m = 0; m < 3; ++m) ours.middleRows(9 * c + 3 * m, 3) = predictions[m].d_theta;
  }
  for (int row = 0; row < 135; ++row) {
    for (int i = 0; i < 18; ++i) {
      // theirs: mm per mm or mm per rad; ours: m per m or m per rad
      const bool length = model_.parameters()[i].quantity == Quantity::kLength;
      theirs(row, i) = expected[row][i].get<double>() * (length ? 1.0 : kMm);
    }
  }
  for (int i = 0; i < 18; ++i) {
    EXPECT_LT((ours.col(i) - theirs.col(i)).cwiseAbs().maxCoeff(), 1e-8 * theirs.col(i).cwiseAbs().maxCoeff())
        << model_.parameters()[i].name;
  }
}

}  // namespace
}  // namespace sagitta::kr270_reference_test
