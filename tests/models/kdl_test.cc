// Forward kinematics against Orocos KDL, which shares no code with ours.
#include <gtest/gtest.h>

#ifdef SAGITTA_HAVE_KDL

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>

#include "models/forward_model.h"
#include "tests/support/arms.h"

namespace sagitta {
namespace {

using test::DhRow;
using test::kDegree;
using test::RandomNumbers;

// KDL puts the joint before a segment's fixed frame: standard DH as it stands;
// in the modified convention the fixed part of a link comes before its joint.
KDL::Chain KdlChain(DhConvention convention, const std::vector<DhRow>& rows) {
  KDL::Chain chain;
  const bool standard = convention == DhConvention::kStandard;
  for (const DhRow& row : rows) {
    const KDL::Joint joint(row.type == JointType::kRevolute ? KDL::Joint::RotZ : KDL::Joint::TransZ);
    const KDL::Frame link =
        standard ? KDL::Frame::DH(row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree)
                 : KDL::Frame::DH_Craig1989(row.a, row.alpha_deg * kDegree, row.d, row.theta_deg * kDegree);
    if (standard) {
      chain.addSegment(KDL::Segment(joint, link));
    } else {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), link));
      chain.addSegment(KDL::Segment(joint));
    }
  }
  return chain;
}

struct Case {
  const char* name;
  DhConvention convention;
  std::vector<DhRow> rows;
};

void PrintTo(const Case& arm, std::ostream* out) { *out << arm.name; }

class Kdl : public ::testing::TestWithParam<Case> {};

TEST_P(Kdl, FlangeAgrees) {
  const Case& arm = GetParam();
  const Chain chain = test::DhArm(arm.convention, arm.rows);
  const ForwardModel model(chain);
  const std::vector<double> no_errors(model.num_parameters(), 0.0);
  const KDL::Chain kdl_chain = KdlChain(arm.convention, arm.rows);
  KDL::ChainFkSolverPos_recursive solver(kdl_chain);
  ASSERT_EQ(static_cast<int>(kdl_chain.getNrOfJoints()), chain.num_joints());
  RandomNumbers random(4711);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::VectorXd q = test::RandomJointValues(chain, &random);
    KDL::JntArray kdl_q(chain.num_joints());
    kdl_q.data = q;
    KDL::Frame expected;
    ASSERT_EQ(solver.JntToCart(kdl_q, expected), 0);
    ChainState<double> state;
    EvaluateChain(chain, model.TransformValues(q, no_errors.data()).data(), &state);
    const Pose<double>& flange_in_base = state.frames[chain.FlangeFrame()];
    const Vector3<double> position(expected.p.x(), expected.p.y(), expected.p.z());
    EXPECT_LE((flange_in_base.translation - position).norm(), 1e-12 * std::max(1.0, position.norm()));
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(flange_in_base.rotation(r, c), expected.M(r, c), 1e-12);
    }
  }
}

std::vector<DhRow> RandomRows(int joints, std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<DhRow> rows;
  for (int j = 0; j < joints; ++j) {
    rows.push_back({random.Uniform(-1, 1), random.Uniform(-180, 180), random.Uniform(-1, 1), random.Uniform(-180, 180),
                    random.Index(4) == 0 ? JointType::kPrismatic : JointType::kRevolute});
  }
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Arms, Kdl,
                         ::testing::Values(Case{"Ur5Standard", DhConvention::kStandard, test::Ur5Rows()},
                                           Case{"PumaStandard", DhConvention::kStandard, test::PumaStandardRows()},
                                           Case{"IiwaStandard", DhConvention::kStandard, test::IiwaRows()},
                                           Case{"TrackStandard", DhConvention::kStandard, test::TrackRows()},
                                           Case{"ScaraStandard", DhConvention::kStandard, test::ScaraRows()},
                                           Case{"PumaModified", DhConvention::kModified, test::PumaModifiedRows()},
                                           Case{"Ur5RowsModified", DhConvention::kModified, test::Ur5Rows()},
                                           Case{"IiwaRowsModified", DhConvention::kModified, test::IiwaRows()},
                                           Case{"TrackRowsModified", DhConvention::kModified, test::TrackRows()},
                                           Case{"RandomStandard", DhConvention::kStandard, RandomRows(8, 5)},
                                           Case{"RandomModified", DhConvention::kModified, RandomRows(8, 6)}),
                         [](const ::testing::TestParamInfo<Case>& arm) { return std::string(arm.param.name); });

}  // namespace
}  // namespace sagitta

#else

TEST(Kdl, FlangeAgrees) { GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics"; }

#endif
