#include "problems/io/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "problems/io/output_files.h"
#include "problems/io/units.h"
#include "problems/text.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::files_test {
namespace {

class FilesTest : public FileTest {};

// FIPS 180-4 examples.
TEST_F(FilesTest, Sha256MatchesNistVectors) {
  EXPECT_EQ(StartOfSha256(""), 0xe3b0c44298fc1c14U);
  EXPECT_EQ(Sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_F(FilesTest, ReadsWhatWasWritten) {
  const std::string bytes("a\r\n\0\xEF\xBB\xBFz", 8);
  WriteTextFile(Path("f"), bytes);
  EXPECT_EQ(ReadTextFile(Path("f")), bytes);
  WriteTextFile(Path("f"), "");
  EXPECT_EQ(ReadTextFile(Path("f")), "");
}

TEST_F(FilesTest, WritingLeavesNoTemporaryFile) {
  WriteTextFile(Path("f"), "x");
  EXPECT_NE(ErrorOf([&] { WriteTextFile(Path("absent/f"), "x"); }), "");
  std::filesystem::create_directories(Path("folder/full"));
  EXPECT_NE(ErrorOf([&] { WriteTextFile(Path("folder"), "x"); }), "");
  int entries = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    (void)entry;
    ++entries;
  }
  EXPECT_EQ(entries, 2);  // f and folder
}

TEST_F(FilesTest, RefusesToReadWhatIsNoFile) {
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadTextFile(Path("absent")); }), {"absent: ", "no such file"}));
  EXPECT_TRUE(SaysInOrder(ErrorOf([&] { ReadTextFile(folder_); }), {folder_, "folder"}));
}

TEST_F(FilesTest, FindsWhatIsNoUtf8) {
  for (const char* text : {"", "plain\n", "\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\xA4\x96", "\xEF\xBB\xBFx"}) {
    EXPECT_EQ(LineOfInvalidUtf8(text), 0) << text;
  }
  for (const char* text :
       {"\n\xFF", "\n\x80", "\n\xC3", "\n\xC3(", "\n\xC0\xAF", "\n\xED\xA0\x80", "\n\xF5\x80\x80\x80"}) {
    EXPECT_EQ(LineOfInvalidUtf8(text), 2) << text;
  }
}

TEST_F(FilesTest, NumbersAreShortAndExact) {
  EXPECT_EQ(FormatNumber(0.1), "0.1");
  EXPECT_EQ(FormatNumber(-1250), "-1250");
  EXPECT_EQ(FormatNumber(0), "0");
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> uniform(-1e4, 1e4);
  for (int i = 0; i < 1000; ++i) {
    const double x = uniform(generator);
    EXPECT_EQ(ParseNumber(FormatNumber(x)), x);
  }
}

TEST(UnitsTest, ParsesWholeFiniteNumbersOnly) {
  EXPECT_EQ(ParseNumber("1.5e-3"), 1.5e-3);
  EXPECT_EQ(ParseNumber("+5"), 5.0);
  EXPECT_EQ(ParseNumber("-.5"), -0.5);
  for (const char* text :
       {"", "nan", "NaN", "inf", "-inf", "1e999", "12_5", "1,5", "1 2", " 1", "0x10", "+-1", "abc", "."}) {
    EXPECT_FALSE(ParseNumber(text).has_value()) << text;
  }
}

// Short decimals are read in one division, others by the library: to the last bit what C reads.
TEST(UnitsTest, DecimalsOfAnyLengthAreWhatCReads) {
  std::mt19937_64 generator(3);
  for (int i = 0; i < 20000; ++i) {
    std::string text = i % 3 == 0 ? "-" : "";
    const int before = static_cast<int>(generator() % 12), after = static_cast<int>(generator() % 12);
    for (int k = 0; k < before; ++k) text += static_cast<char>('0' + generator() % 10);
    if (i % 5 != 0) text += '.';
    for (int k = 0; k < after && i % 5 != 0; ++k) text += static_cast<char>('0' + generator() % 10);
    const bool has_digit = before > 0 || (after > 0 && i % 5 != 0);
    ASSERT_EQ(ParseNumber(text).has_value(), has_digit) << text;
    if (!has_digit) continue;
    EXPECT_EQ(*ParseNumber(text), std::strtod(text.c_str(), nullptr)) << text;
  }
  // 2^53, and the first whole number beyond that is no double.
  for (const char* text : {"9007199254740992", "9007199254740993", "900719.9254740993", "0.000000000000000001",
                           "999999999999999999", "1234567890123456789"}) {
    EXPECT_EQ(ParseNumber(text), std::strtod(text, nullptr)) << text;
  }
  EXPECT_TRUE(std::signbit(*ParseNumber("-0")));
  for (const char* text : {"-", "-.", "1.2.3", "1..2", "--1", "1-2", "-+1", "1.-2", "/5", "5:"}) {
    EXPECT_FALSE(ParseNumber(text).has_value()) << text;
  }
}

TEST(UnitsTest, AreThoseOfTheirNames) {
  const std::map<std::string, double> si = {{"m", 1.0},
                                            {"mm", 1e-3},
                                            {"um", 1e-6},
                                            {"rad", 1.0},
                                            {"mrad", 1e-3},
                                            {"urad", 1e-6},
                                            {"deg", std::acos(-1.0) / 180.0}};
  for (const auto& [name, value] : si) EXPECT_NEAR(UnitNamed(name).ToSi(2.0), 2.0 * value, 1e-15 * value) << name;
}

TEST(UnitsTest, ConvertsThereAndBack) {
  EXPECT_EQ(UnitNamed("mm").ToSi(89.159), 0.089159);
  EXPECT_EQ(ToUnit(0.089159, UnitNamed("mm")), 89.159);
  EXPECT_EQ(ToUnit(UnitNamed("deg").ToSi(-101.3), UnitNamed("deg")), -101.3);
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> uniform(-4, 4);
  for (int i = 0; i < 1000; ++i) {
    const double si = uniform(generator);
    for (const char* unit : {"mm", "deg", "urad"}) {
      EXPECT_NEAR(UnitNamed(unit).ToSi(ToUnit(si, UnitNamed(unit))), si, 4 * std::numeric_limits<double>::epsilon());
    }
  }
}

}  // namespace
}  // namespace sagitta::files_test
