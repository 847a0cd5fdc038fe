// The default free set: complete (nothing left out adds rank), minimal (nothing
// kept can go), continuous (the same on both sides of parallel), for many arms.
// Ranks are decided here by an SVD on other configurations and other marker
// points than the implementation uses.
#include "models/default_free_set.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <numeric>
#include <set>

#include "models/forward_model.h"
#include "tests/support/arms.h"
#include "tests/support/kr270.h"

namespace sagitta::default_free_set_test {
namespace {

using test::DhRow;
using test::RandomNumbers;

using Names = std::set<std::string>;

Names AsSet(const std::vector<std::string>& names) { return {names.begin(), names.end()}; }

// The whitened identification Jacobian: base (6), markers (3 each), then the named errors.
class GenericData {
 public:
  GenericData(const Chain& chain, int markers, std::uint64_t seed) : model_(chain), markers_(markers) {
    RandomNumbers random(seed);
    const int n = model_.num_parameters();
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    const std::vector<double> theta(n, 0.0);
    const int configurations = 3 * n;
    std::vector<MarkerInFrame> points;
    for (int m = 0; m < markers; ++m) points.push_back({chain.FlangeFrame(), random.Vector(0.5)});
    Pose<double> base_in_station;
    base_in_station.rotation = RotationFromVector<double>(random.Vector(1.0));
    base_in_station.translation = random.Vector(2.0);
    jacobian_ = Eigen::MatrixXd::Zero(3 * markers * configurations, 6 + 3 * markers + n);
    for (int c = 0; c < configurations; ++c) {
      std::vector<PointPrediction> predictions;
      model_.Predict(test::RandomJointValues(chain, &random), theta.data(), all, base_in_station, points, &predictions);
      for (int m = 0; m < markers; ++m) {
        auto rows = jacobian_.middleRows(3 * (c * markers + m), 3);
        rows.leftCols<3>().setIdentity();
        rows.middleCols<3>(3) = predictions[m].d_rotation;
        rows.middleCols<3>(6 + 3 * m) = predictions[m].d_marker;
        rows.rightCols(n) = predictions[m].d_theta;
      }
    }
    for (int i = 0; i < jacobian_.cols(); ++i) {
      const double norm = jacobian_.col(i).norm();
      if (norm > 1e-12) jacobian_.col(i) /= norm;
    }
  }

  int Rank(const Names& errors, bool base = true, bool markers = true) const {
    std::vector<int> columns;
    for (int i = 0; i < 6; ++i) {
      if (base) columns.push_back(i);
    }
    for (int i = 0; i < 3 * markers_; ++i) {
      if (markers) columns.push_back(6 + i);
    }
    for (const std::string& error : errors) columns.push_back(Column(error));
    Eigen::MatrixXd selected(jacobian_.rows(), columns.size());
    for (size_t i = 0; i < columns.size(); ++i) selected.col(i) = jacobian_.col(columns[i]);
    const Eigen::VectorXd singular =
        Eigen::JacobiSVD<Eigen::MatrixXd>(selected.transpose() * selected).singularValues();
    // Eigenvalues of the normal matrix: 1e-11 is a sine of 3e-6.
    return static_cast<int>((singular.array() > 1e-11 * singular[0]).count());
  }

 private:
  int Column(const std::string& error) const {
    for (int i = 0; i < model_.num_parameters(); ++i) {
      if (model_.parameters()[i].name == "geometry/" + error) return 6 + 3 * markers_ + i;
    }
    ADD_FAILURE() << error;
    return 0;
  }

  ForwardModel model_;
  int markers_;
  Eigen::MatrixXd jacobian_;
};

void ExpectCompleteAndMinimal(const Chain& chain, const FreeSet& set, int markers, bool base = true,
                              bool markers_free = true) {
  const GenericData data(chain, markers, 90210);
  const Names kept = AsSet(set.free);
  const int others = data.Rank({}, base, markers_free);
  const int rank = data.Rank(kept, base, markers_free);
  EXPECT_EQ(rank, others + static_cast<int>(kept.size())) << "kept columns are dependent";
  for (const std::string& error : set.free) {
    Names fewer = kept;
    fewer.erase(error);
    EXPECT_EQ(data.Rank(fewer, base, markers_free), rank - 1) << "without " << error;
  }
  for (const std::string& error : set.redundant) {
    Names more = kept;
    more.insert(error);
    EXPECT_EQ(data.Rank(more, base, markers_free), rank) << "with " << error;
  }
}

struct Case {
  std::string name;
  Chain chain;
  int expected;  // 4R + 2P + 6 - 6 (base) - 6 (tool)
};

void PrintTo(const Case& arm, std::ostream* out) { *out << arm.name; }

class DefaultFreeSetOf : public ::testing::TestWithParam<Case> {};

TEST_P(DefaultFreeSetOf, HasTheCountOfTheFormula) {
  const FreeSet set = DefaultFreeSet(GetParam().chain);
  EXPECT_EQ(static_cast<int>(set.free.size()), GetParam().expected);
  const ForwardModel model(GetParam().chain);
  EXPECT_EQ(static_cast<int>(set.free.size() + set.redundant.size()), model.num_parameters());
}

TEST_P(DefaultFreeSetOf, IsCompleteAndMinimalForOneMarker) {
  ExpectCompleteAndMinimal(GetParam().chain, DefaultFreeSet(GetParam().chain), 1);
}

TEST_P(DefaultFreeSetOf, IsCompleteAndMinimalForThreeMarkers) {
  ExpectCompleteAndMinimal(GetParam().chain, DefaultFreeSet(GetParam().chain), 3);
}

std::vector<Case> Cases() {
  RandomNumbers random(31);
  std::vector<DhRow> generic;
  for (int j = 0; j < 6; ++j) {
    generic.push_back(
        {random.Uniform(0.1, 0.6), random.Uniform(15, 75), random.Uniform(0.1, 0.6), random.Uniform(-90, 90)});
  }
  using test::DhArm;
  constexpr DhConvention kStandard = DhConvention::kStandard;
  constexpr DhConvention kModified = DhConvention::kModified;
  return {{"Kr270", test::Kr270Chain(), 18},
          {"Ur5", DhArm(kStandard, test::Ur5Rows()), 18},
          {"PumaStandard", DhArm(kStandard, test::PumaStandardRows()), 18},
          {"PumaModified", DhArm(kModified, test::PumaModifiedRows()), 18},
          {"Generic6R", DhArm(kStandard, generic), 18},
          {"Generic6RModified", DhArm(kModified, generic), 18},
          {"Iiwa7R", DhArm(kStandard, test::IiwaRows()), 22},
          {"Iiwa7RModified", DhArm(kModified, test::IiwaModifiedRows()), 22},
          {"PrismaticFirst", DhArm(kStandard, test::TrackRows()), 20},
          {"PrismaticFirstModified", DhArm(kModified, test::TrackModifiedRows()), 20},
          // All axes vertical: base z and tool z are one unknown, one error more is free.
          {"Scara", DhArm(kStandard, test::ScaraRows()), 8 + 1},
          {"ScaraModified", DhArm(kModified, test::ScaraModifiedRows()), 8 + 1}};
}

INSTANTIATE_TEST_SUITE_P(Arms, DefaultFreeSetOf, ::testing::ValuesIn(Cases()),
                         [](const ::testing::TestParamInfo<Case>& arm) { return arm.param.name; });

TEST(DefaultFreeSet, Kr270KeepsTheEighteenPublishedErrorsInOrder) {
  const FreeSet set = DefaultFreeSet(test::Kr270Chain());
  EXPECT_EQ(set.free, test::Kr270Errors());
  EXPECT_TRUE(set.redundant.empty());
}

void InsertAfter(const std::string& error, const ElementaryTransform& transform, Chain* chain) {
  const auto at = chain->transforms.begin() + chain->FindError(error) + 1;
  chain->transforms.insert(at, transform);
}

// The gauge list of the published reference: each of these moves the markers as
// base, tool points or the eighteen do.
TEST(DefaultFreeSet, Kr270LeavesRedundantErrorsOut) {
  Chain chain = test::Kr270Chain();
  chain.transforms[chain.JointTransform(0)].error = "dq1";
  chain.transforms[chain.JointTransform(5)].error = "dq6";
  chain.transforms.front().error = "d1";
  chain.transforms.back().error = "d6";
  InsertAfter("p_y1", test::Translate(Axis::kZ, 0, "p_z1"), &chain);
  InsertAfter("phi_x1", test::Rotate(Axis::kY, 0, "phi_y1"), &chain);
  InsertAfter("p_x2", test::Translate(Axis::kY, 0, "p_y2"), &chain);
  InsertAfter("p_y2", test::Translate(Axis::kZ, 0, "p_z2"), &chain);
  InsertAfter("p_x3", test::Translate(Axis::kY, 0, "p_y3"), &chain);
  InsertAfter("dq4", test::Translate(Axis::kX, 0, "p_x4"), &chain);
  InsertAfter("dq5", test::Translate(Axis::kX, 0, "p_x5"), &chain);
  ASSERT_EQ(chain.Defect(), "");
  const FreeSet set = DefaultFreeSet(chain);
  EXPECT_EQ(set.free, test::Kr270Errors());
  EXPECT_EQ(AsSet(set.redundant),
            (Names{"d1", "dq1", "p_z1", "phi_y1", "p_y2", "p_z2", "p_y3", "p_x4", "p_x5", "dq6", "d6"}));
  ExpectCompleteAndMinimal(chain, set, 3);
}

TEST(DefaultFreeSet, HayatiBetaTakesOverFromDOnParallelAxes) {
  const Names kept = AsSet(DefaultFreeSet(test::DhArm(DhConvention::kStandard, test::Ur5Rows())).free);
  EXPECT_EQ(kept, (Names{"j1.a", "j1.alpha",                                 //
                         "j2.theta", "j2.d", "j2.a", "j2.alpha", "j2.beta",  //
                         "j3.theta", "j3.a", "j3.alpha", "j3.beta",          //
                         "j4.theta", "j4.a", "j4.alpha",                     //
                         "j5.theta", "j5.d", "j5.a", "j5.alpha"}));
}

TEST(DefaultFreeSet, IsTheSameOnBothSidesOfParallel) {
  const FreeSet parallel = DefaultFreeSet(test::DhArm(DhConvention::kStandard, test::Ur5Rows()));
  for (const double off_deg : {-2.0, -0.5, -1e-3, -1e-9, 1e-9, 1e-3, 0.5, 2.0}) {
    for (const int link : {0, 1, 2, 3, 4}) {
      std::vector<DhRow> rows = test::Ur5Rows();
      rows[link].alpha_deg += off_deg;
      if (link == 1) rows[2].alpha_deg -= 0.5 * off_deg;
      const Chain chain = test::DhArm(DhConvention::kStandard, rows);
      const FreeSet set = DefaultFreeSet(chain);
      EXPECT_EQ(set.free, parallel.free) << "link " << link + 1 << " off by " << off_deg;
      EXPECT_EQ(set.redundant, parallel.redundant);
    }
  }
}

// Half a degree off parallel the set is still complete and minimal on the arm as it is.
TEST(DefaultFreeSet, IsCompleteAndMinimalNearParallel) {
  for (const double off_deg : {-0.5, 0.5}) {
    std::vector<DhRow> rows = test::Ur5Rows();
    rows[1].alpha_deg += off_deg;
    rows[2].alpha_deg -= 2.0 * off_deg;
    const Chain chain = test::DhArm(DhConvention::kStandard, rows);
    ExpectCompleteAndMinimal(chain, DefaultFreeSet(chain), 1);
  }
}

TEST(DefaultFreeSet, DoesNotDependOnSmallNominalErrors) {
  const Names expected = AsSet(DefaultFreeSet(test::DhArm(DhConvention::kStandard, test::Ur5Rows())).free);
  RandomNumbers random(8);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<DhRow> rows = test::Ur5Rows();
    for (DhRow& row : rows) {
      row.a += random.Uniform(-1e-3, 1e-3);
      row.d += random.Uniform(-1e-3, 1e-3);
      row.alpha_deg += random.Uniform(-0.2, 0.2);
      row.beta_deg += random.Uniform(-0.2, 0.2);
    }
    EXPECT_EQ(AsSet(DefaultFreeSet(test::DhArm(DhConvention::kStandard, rows)).free), expected);
  }
}

// Then the first joint's zero and height are unknowns too. (That the first axis
// stands on its nominal line is all that a standard table can say.)
TEST(DefaultFreeSet, AKnownBaseFreesTheFirstLink) {
  FreeSetContext context;
  context.base_free = false;
  for (const auto& rows : {test::Ur5Rows(), test::PumaStandardRows()}) {
    const Chain chain = test::DhArm(DhConvention::kStandard, rows);
    const FreeSet set = DefaultFreeSet(chain, context);
    EXPECT_EQ(set.free.size(), 18u + 2u);
    ExpectCompleteAndMinimal(chain, set, 3, false, true);
  }
  const Chain modified = test::DhArm(DhConvention::kModified, test::PumaModifiedRows());
  const FreeSet set = DefaultFreeSet(modified, context);
  EXPECT_EQ(set.free.size(), 18u + 5u);  // alpha, a, beta, theta, d; its y position has no name in a DH table
  ExpectCompleteAndMinimal(modified, set, 3, false, true);
}

// Three known points on the flange fix its whole pose.
TEST(DefaultFreeSet, KnownMarkersFreeTheToolsErrors) {
  const Chain chain = test::DhArm(DhConvention::kStandard, test::Ur5Rows());
  FreeSetContext context;
  context.markers_free = false;
  const FreeSet set = DefaultFreeSet(chain, context);
  ExpectCompleteAndMinimal(chain, set, 3, true, false);
}

}  // namespace
}  // namespace sagitta::default_free_set_test
