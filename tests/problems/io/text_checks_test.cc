// Texts from files where they are shown or written: terminal, table, shell, page.
#include "problems/io/text_checks.h"

#include <array>
#include <cstdio>
#include <memory>

#include "problems/io/csv_table.h"
#include "problems/io/files.h"
#include "tests/problems/file_test_support.h"

namespace sagitta::text_checks_test {
namespace {

TEST(TextChecksTest, ControlCharactersAreFoundAndShown) {
  EXPECT_FALSE(
      HasControlCharacter("Gr\xC3\xB6\xC3\x9F"
                          "e 1.5 \xE2\x82\xAC"));
  EXPECT_EQ(FindControlCharacter("ab\x1b[2J"), 2u);
  EXPECT_EQ(FindControlCharacter(std::string("a\0b", 3)), 1u);
  EXPECT_EQ(FindControlCharacter("a\xC2\x9B"), 1u);  // C1: CSI
  EXPECT_EQ(NameOfControlCharacter("a\xC2\x9B", 1), "U+009B");
  EXPECT_EQ(Printable("a\x1b[2J\tb\n\x7f\xC2\x9Bz"), "a\\x1b[2J\\tb\\n\\x7f\\x9bz");
  EXPECT_EQ(Printable("a\tb\r\n", true), "a\tb\\x0d\n");
}

TEST(TextChecksTest, PagesAreUtf8) {
  EXPECT_EQ(ValidUtf8("gr\xC3\xB6n"), "gr\xC3\xB6n");
  EXPECT_EQ(ValidUtf8("a\xFF"
                      "b\xC3"),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD");
  EXPECT_EQ(LineOfInvalidUtf8(ValidUtf8("\xED\xA0\x80\xF5\xC0\xAF")), 0);
}

TEST(TextChecksTest, FormulasAreTextsAndNumbersAreNumbers) {
  EXPECT_EQ(CsvCell("=1+1"), "'=1+1");
  EXPECT_EQ(CsvCell("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(CsvCell("+cmd|' /C calc'!A0"), "'+cmd|' /C calc'!A0");
  EXPECT_EQ(CsvCell("=HYPERLINK(\"a\",1)"), "\"'=HYPERLINK(\"\"a\"\",1)\"");
  for (const char* plain : {"-1.5", "+2", "-1e-3", "M1", "-", "", "'quoted'", "a=b", "x-1"}) {
    EXPECT_EQ(CsvCell(plain), plain);
  }
}

// What is written into a table is what is read out of it.
TEST(TextChecksTest, GuardedCellsReadBack) {
  for (const char* text :
       {"=1+1", "'=1+1", "''-x", "-x", "-1.5", "a,b", "\"", "#1", "'a", "@f", "+", " b", "=\"a\",b"}) {
    const CsvTable table = ParseCsvTable("a,b\n" + CsvCell(text) + ",1\n", "t.csv");
    EXPECT_EQ(table.file.rows.at(0).cells.at(0), text);
  }
}

// Cells that are read together are those that stand as they are one by one; the usual ones are.
TEST(TextChecksTest, CellsTogetherAreThoseOneByOne) {
  const auto taken = [](const std::string& cells, size_t count) {
    std::string line = "before,";
    const bool all = AddCsvCells(cells, count, &line);
    EXPECT_EQ(line, all ? "before," + cells : "before,");
    return all;
  };
  EXPECT_TRUE(taken("C1,M_1,-12.5,,0.25,-3", 6));
  EXPECT_TRUE(taken("", 1));
  EXPECT_FALSE(taken("a,b", 1));  // one cell with a comma in it
  const std::string long_number = "-" + std::string(400, '9');
  for (const std::string& cell : std::vector<std::string>{"-", "-x", "-1.2.3", "-.", "=1", "+1", "@f", "#1", " b", "b ",
                                                          "\"", "'a", "x-1", "a\tb", "a\nb", "-1-1", long_number}) {
    for (const std::string& cells : {cell + ",1,2", "1," + cell + ",2", "1,2," + cell}) {
      if (!taken(cells, 3)) continue;
      EXPECT_EQ(CsvCell(cell), cell);
    }
  }
  for (const char* cell : {"=1", "-x", "-", "#1", " b", "a\nb"}) EXPECT_FALSE(taken(cell, 1)) << cell;
}

TEST(TextChecksTest, TheShellReadsWordsBack) {
  for (const std::string& word : std::vector<std::string>{"a b", "it's", "$(touch x)", "`x`", "a\nb", "*", "\\", "",
                                                          "-n", "~", "a;b", "#c", "!"}) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(("printf %s " + ShellWord(word)).c_str(), "r"), pclose);
    std::array<char, 100> buffer{};
    const size_t count = fread(buffer.data(), 1, buffer.size(), pipe.get());
    EXPECT_EQ(std::string(buffer.data(), count), word);
  }
  EXPECT_EQ(ShellWord("a/b-c_1.csv"), "a/b-c_1.csv");
}

TEST(CsvControlTest, IdsHoldNoControlCharacters) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { ParseCsvTable(text, "t.csv"); }); };
  EXPECT_TRUE(SaysInOrder(error("a,b\n1,x\x1b[2J\n"), {"t.csv:2", "U+001B"}));
  EXPECT_TRUE(SaysInOrder(error("a,b\n1,2\n" + std::string("M\0,3\n", 5)), {"t.csv:3", "U+0000"}));
  EXPECT_TRUE(SaysInOrder(error("a,\xC2\x9Bz\n1,2\n"), {"t.csv:1", "U+009B"}));
  EXPECT_TRUE(SaysInOrder(error("a,b\n1\r1,2\n"), {"t.csv:2", "U+000D"}));
  EXPECT_TRUE(SaysInOrder(error("a,b\n1,\x7F\n"), {"t.csv:2", "U+007F"}));
  EXPECT_EQ(error("a,b\r\n1,\t2\r\n"), "");
}

TEST(CsvControlTest, SizesAreLimited) {
  const auto error = [](const std::string& text) { return ErrorOf([&] { ParseCsvTable(text, "t.csv"); }); };
  EXPECT_TRUE(SaysInOrder(error(std::string(5000, ',')), {"t.csv:1", "4096"}));
}

}  // namespace
}  // namespace sagitta::text_checks_test
