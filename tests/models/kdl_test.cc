// Forward kinematics against Orocos KDL, which shares no code with ours.
#include <gtest/gtest.h>

#include "tests/support/kdl_chain.h"

#ifdef SAGITTA_HAVE_KDL

namespace sagitta::kdl_test {
namespace {

using test::DhRow;
using test::RandomNumbers;

struct Case {
  const char* name;
  DhConvention convention;
  std::vector<DhRow> rows;
};

void PrintTo(const Case& arm, std::ostream* out) { *out << arm.name; }

class Kdl : public ::testing::TestWithParam<Case> {};

TEST_P(Kdl, FlangeAgrees) {
  const Case& arm = GetParam();
  test::ExpectSameFlange(test::DhArm(arm.convention, arm.rows), test::KdlChainOfDh(arm.convention, arm.rows), 1e-12,
                         500);
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
}  // namespace sagitta::kdl_test

#else

TEST(Kdl, FlangeAgrees) { GTEST_SKIP() << "liborocos-kdl-dev is not installed: no independent forward kinematics"; }

#endif
