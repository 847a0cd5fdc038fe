// Columns of measurement files that are nearly read, and those that are not read.
#include "problems/io/measurement_columns.h"

#include <gtest/gtest.h>

#include <map>

#include "problems/io/measurement_file.h"
#include "problems/split.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::measurement_columns_test {
namespace {

constexpr char kHead[] = "config,marker,q1_deg,q2_mm,x_mm,y_mm,z_mm";

class MeasurementColumnsTest : public FileTest {
 protected:
  Measurements Read(const std::string& text) {
    return ReadMeasurements({Write("m.csv", text)}, {"A1", "L2"}, {false, true});
  }
  std::string ErrorWith(const std::string& column) {
    return ErrorOf([&] { Read(std::string(kHead) + "," + column + "\nC1,M1,10,200,1,2,3,4\n"); });
  }
};

// A force of fx_kp would be none at all.
TEST_F(MeasurementColumnsTest, AUnitThatIsNotReadIsAnError) {
  const std::map<std::string, std::vector<std::string>> expected = {
      {"fx_kp", {"'kp' is no unit", "fx", "convert", "'fx_N'"}},
      {"fx_lbf", {"'lbf' is no unit", "'fx_N'"}},
      {"fx_kN", {"'kN' is no unit", "'fx_N'"}},
      {"fx_mN", {"'mN' is no unit", "'fx_N'"}},
      {"fz [daN]", {"'daN' is no unit", "'fz_N'"}},
      {"my_lbft", {"'lbft' is no unit", "'my_Nm'"}},
      {"mx_kgfm", {"'kgfm' is no unit", "'mx_Nm'"}},
      {"mx_lb_in", {"'lb_in' is no unit", "'mx_Nm'"}},
      {"tau1_lbft", {"'lbft' is no unit", "'tau1_Nm'"}},
      {"q1_gon", {"'gon' is no unit", "'q1_deg', 'q1_rad'"}},
      {"rx_gon", {"'gon' is no unit", "'rx_deg'", "'rx_mrad'"}},
      {"sigma_rot_arcsec", {"'arcsec' is no unit", "'sigma_rot_urad'"}},
      {"temperature_R", {"'R' is no unit", "'temperature_degC'"}},
      {"Temperature [K]", {"'K' is no unit", "'temperature_degC'"}},
      {"time_min", {"'min' is no unit", "'time_s'"}}};
  for (const auto& [column, words] : expected) {
    std::vector<std::string> says = {"m.csv:1: " + column};
    says.insert(says.end(), words.begin(), words.end());
    EXPECT_TRUE(SaysInOrder(ErrorWith(column), says)) << ErrorWith(column);
  }
}

TEST_F(MeasurementColumnsTest, OtherSpellingsAreErrors) {
  EXPECT_TRUE(SaysInOrder(ErrorWith("temp_degC"), {"temp_degC", "'temperature_degC'"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("approach"), {"approach", "which joint", "approach1"}));
  EXPECT_TRUE(SaysInOrder(ErrorWith("OW"), {"OW", "unknown", "'ow'"}));
  for (const char* column : {"Session", "KIND", "range_m", "sigma_range_um"}) {
    EXPECT_TRUE(SaysInOrder(ErrorWith(column), {column, "reserved"}));
  }
}

// What nothing reads is listed, what splits the data is read.
TEST_F(MeasurementColumnsTest, ColumnsThatAreNotReadAreListed) {
  const std::string head = kHead;
  Measurements data = Read(head + ",load_id,fx_raw,x_target,x_min,ow,ox,oy,oz\nC1,M1,1,2,3,4,5,L,0,3,1,1,0,0,0\n");
  EXPECT_EQ(data.unread_columns, (std::vector<std::string>{"load_id", "fx_raw", "x_target", "x_min"}));
  data = Read(head + ",group,pred_x_mm\nC1,M1,1,2,3,4,5,a,3\nC2,M1,2,2,3,4,5,b,3\n");
  ValidationSpec spec;
  spec.kind = ValidationSpec::Kind::kColumn;
  spec.column = "group";
  spec.values = {"b"};
  SplitConfigurations(spec, &data);
  EXPECT_EQ(data.unread_columns, std::vector<std::string>{"pred_x_mm"});
  EXPECT_TRUE(Read(head + "\nC1,M1,1,2,3,4,5\n").unread_columns.empty());
}

}  // namespace
}  // namespace sagitta::measurement_columns_test
