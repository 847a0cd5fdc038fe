// sagitta reproduce: runs, judges what it should, and refuses what it cannot read.
#include <cmath>
#include <set>

#include "tests/support/paths.h"
#include "tests/tools/program.h"

namespace sagitta::test::reproduce_test {
namespace {

class ReproduceTest : public ProgramTest {
 protected:
  // Runs into a folder of that name; few trials.
  Outcome Reproduce(std::vector<std::string> arguments, const std::string& folder) const {
    arguments.insert(arguments.begin(), "reproduce");
    arguments.insert(arguments.end(), {"--trials=20", "--quiet", "--out=" + Path(folder)});
    return Run(arguments);
  }

  static nlohmann::json Row(const nlohmann::json& table, const std::string& quantity) {
    for (const auto& row : table["rows"]) {
      if (row["quantity"] == quantity) return row;
    }
    ADD_FAILURE() << "no row " << quantity;
    return {};
  }
  static void ExpectComputed(const nlohmann::json& table, const std::string& quantity, double expected,
                             double tolerance, const std::string& verdict) {
    const nlohmann::json row = Row(table, quantity);
    if (row.is_null()) return;
    EXPECT_NEAR(row["computed"].get<double>(), expected, tolerance) << quantity;
    EXPECT_EQ(row["verdict"], verdict) << quantity;
  }
};

const char* const kTables[] = {"000-I",     "000-II",  "000-III",  "000-IV",   "002-I",    "002-II",   "002-III",
                               "002-IV",    "002-V",   "002-VI",   "002-VII",  "002-VIII", "002-IX",   "002-X",
                               "002-XI",    "002-XII", "002-XIII", "002-fig4", "002-fig5", "002-fig8", "002-fig9",
                               "002-fig10", "003-1",   "003-2",    "003-3",    "003-4",    "003-fig3"};

TEST_F(ReproduceTest, AllTablesInOrderEachWithItsNote) {
  const Outcome outcome = Reproduce({}, "out");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = ReadJson("out/reproduce.json");
  ASSERT_EQ(json["tables"].size(), std::size(kTables));
  const std::set<std::string> verdicts = {"reproduced", "order of magnitude", "not reproducible", "input",
                                          "not in the paper"};
  const std::string note = json["note"], page = Read("out/report.html");
  EXPECT_NE(note.find("No raw measurements"), std::string::npos);
  size_t notes = 0;
  for (size_t at = page.find(note); at != std::string::npos; at = page.find(note, at + 1)) ++notes;
  EXPECT_EQ(notes, std::size(kTables) + 1);
  for (size_t t = 0; t < std::size(kTables); ++t) {
    const auto& table = json["tables"][t];
    EXPECT_EQ(table["id"], kTables[t]);
    EXPECT_EQ(table["note"], note);
    EXPECT_FALSE(table["rows"].empty()) << kTables[t];
    EXPECT_NE(outcome.out.find(std::string(kTables[t]) + "  "), std::string::npos) << kTables[t];
    EXPECT_NE(page.find("id=\"" + std::string(kTables[t]) + "\""), std::string::npos) << kTables[t];
    for (const auto& row : table["rows"]) {
      EXPECT_EQ(verdicts.count(row["verdict"]), 1u) << row;
      EXPECT_EQ(row["computed"].dump().find("nan"), std::string::npos) << kTables[t] << row;
      EXPECT_FALSE(row["computed"].is_null()) << kTables[t] << row;
      // A verdict that something cannot be had always says why.
      EXPECT_TRUE(row["verdict"] != "not reproducible" || row.contains("why")) << kTables[t] << row;
    }
  }
  EXPECT_NE(page.find("</html>"), std::string::npos);
}

TEST_F(ReproduceTest, DeflectionsBeforeCompensation) {
  ASSERT_EQ(Reproduce({"002-VIII"}, "out").status, 0);
  const auto json = ReadJson("out/reproduce.json");
  ASSERT_EQ(json["tables"].size(), 1u);
  const auto& table = json["tables"][0];
  ExpectComputed(table, "coordinate RMS before, mm", 3.16, 0.005, "reproduced");
  ExpectComputed(table, "coordinate max before, mm", 8.96, 0.005, "reproduced");
  ExpectComputed(table, "distance RMS before, mm", 5.47, 0.005, "reproduced");
  ExpectComputed(table, "distance max before, mm", 9.00, 0.005, "reproduced");
  EXPECT_EQ(Row(table, "coordinate RMS after, mm")["verdict"], "not reproducible");
}

TEST_F(ReproduceTest, WeightsGainLittleHonestly) {
  ASSERT_EQ(Reproduce({"003-4"}, "out").status, 0);
  const auto json = ReadJson("out/reproduce.json");
  const auto& table = json["tables"][0];
  const double factors[9] = {1.61, 1.32, 1.25, 1.29, 1.39, 1.46, 1.73, 1.46, 1.72};
  const char* names[9] = {"k21", "k22", "k23", "k24", "k25", "k3", "k4", "k5", "k6"};
  for (int p = 0; p < 9; ++p) {
    ExpectComputed(table, std::string(names[p]) + " OLS / WLS, honest", factors[p], 0.006, "not reproducible");
    EXPECT_GT(Row(table, std::string(names[p]) + " OLS / WLS, per residual")["computed"], 4.56) << names[p];
  }
  EXPECT_EQ(Row(table, "largest gain any design allows")["computed"], "4.56");
  const auto honest = Row(table, "WLS, known sigmas, eq. 13")["numbers"];
  const auto trick = Row(table, "per residual, eq. 14, eq. 13 with |r|")["numbers"];
  EXPECT_GT(honest["coverage_95"], 0.8);  // 20 trials
  EXPECT_LT(trick["coverage_95"], 0.3);
  EXPECT_LT(trick["claimed_over_actual"], 0.1);
}

TEST_F(ReproduceTest, CompensatorAsTheReference) {
  ASSERT_EQ(Reproduce({"002-V", "002-VII"}, "out").status, 0);
  const auto json = ReadJson("out/reproduce.json");
  ExpectComputed(json["tables"][0], "interval of a_x, mm", 0.14, 0.005, "not reproducible");
  ExpectComputed(json["tables"][0], "interval of a_y, mm", 0.25, 0.005, "not reproducible");
  ExpectComputed(json["tables"][0], "interval of a_x, mm, noisy anchor", 0.70, 0.01, "order of magnitude");
  ExpectComputed(json["tables"][1], "kc, um/N", 0.138, 0.0015, "reproduced");
  ExpectComputed(json["tables"][1], "s0, mm", 457.0, 7.0, "reproduced");
  ExpectComputed(json["tables"][1], "k0, urad/(N m)", 0.3035, 0.0016, "reproduced");
  ExpectComputed(json["tables"][1], "interval of s0, mm", 145.0, 1.0, "not reproducible");
}

TEST_F(ReproduceTest, APaperIsItsTables) {
  ASSERT_EQ(Reproduce({"003"}, "out").status, 0);
  const auto json = ReadJson("out/reproduce.json");
  ASSERT_EQ(json["tables"].size(), 5u);
  EXPECT_EQ(json["tables"][4]["id"], "003-fig3");
  EXPECT_NE(Read("out/report.html").find("k21 over iterations"), std::string::npos);
}

TEST_F(ReproduceTest, SeedsDecide) {
  ASSERT_EQ(Reproduce({"003-fig3"}, "a").status, 0);
  ASSERT_EQ(Reproduce({"003-fig3"}, "b").status, 0);
  ASSERT_EQ(Reproduce({"003-fig3", "--seed=5"}, "c").status, 0);
  EXPECT_EQ(ReadJson("a/reproduce.json")["tables"], ReadJson("b/reproduce.json")["tables"]);
  EXPECT_NE(ReadJson("a/reproduce.json")["tables"], ReadJson("c/reproduce.json")["tables"]);
}

TEST_F(ReproduceTest, UnknownTableNamesTheNearest) {
  const Outcome outcome = Reproduce({"002-XIIII"}, "out");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("did you mean '002-XIII'"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_FALSE(Exists("out"));
}

TEST_F(ReproduceTest, BadTrialsAreUsageErrors) {
  for (const char* flag : {"--trials=1", "--trials=0", "--trials=-5", "--trials=abc", "--trials=100000000"}) {
    const Outcome outcome = Run({"reproduce", "002-VIII", flag, "--out=" + Path("out")});
    EXPECT_EQ(outcome.status, 2) << flag;
    EXPECT_FALSE(Exists("out")) << flag;
  }
}

TEST_F(ReproduceTest, DataFolderByFlagAndEnvironment) {
  const std::filesystem::path copy = Path("data");
  std::filesystem::copy(test::SourceFolder() + "/problems/published", copy, std::filesystem::copy_options::recursive);
  EXPECT_EQ(Reproduce({"002-VIII", "--data=" + copy.string()}, "a").status, 0);
  auto tables = nlohmann::json::parse(ReadAll(copy / "kr270/published.json"));
  tables["scene"]["load_kg"] = 500.0;  // twice the load, twice the deflection
  Write("data/kr270/published.json", tables.dump());
  EXPECT_EQ(Reproduce({"002-VIII", "--data=" + copy.string()}, "b").status, 0);
  setenv("SAGITTA_DATA", copy.c_str(), 1);
  const Outcome by_environment = Reproduce({"002-VIII"}, "c");
  unsetenv("SAGITTA_DATA");
  EXPECT_EQ(by_environment.status, 0);
  const auto rms = [this](const std::string& folder) {
    return Row(ReadJson(folder + "/reproduce.json")["tables"][0], "coordinate RMS before, mm")["computed"]
        .get<double>();
  };
  EXPECT_NEAR(rms("b"), 2.0 * rms("a"), 1e-9);
  EXPECT_EQ(rms("c"), rms("b"));
}

TEST_F(ReproduceTest, MissingAndMutilatedDataAreInputErrors) {
  const Outcome missing = Reproduce({"002-VIII", "--data=" + Path("nowhere")}, "a");
  EXPECT_EQ(missing.status, 2);
  EXPECT_NE(missing.err.find("published.json"), std::string::npos) << missing.err;
  const std::filesystem::path copy = Path("data");
  std::filesystem::copy(test::SourceFolder() + "/problems/published", copy, std::filesystem::copy_options::recursive);
  auto tables = nlohmann::json::parse(ReadAll(copy / "kr270/published.json"));
  tables.erase("002-VIII");
  Write("data/kr270/published.json", tables.dump());
  const Outcome lacking = Reproduce({"002-VIII", "--data=" + copy.string()}, "b");
  EXPECT_EQ(lacking.status, 2);
  EXPECT_NE(lacking.err.find("002-VIII"), std::string::npos) << lacking.err;
  Write("data/kr270/published.json", "{");
  EXPECT_EQ(Reproduce({"002-VIII", "--data=" + copy.string()}, "c").status, 2);
  for (const char* folder : {"a", "b", "c"}) {
    EXPECT_FALSE(Exists(std::string(folder) + "/report.html"));
    EXPECT_FALSE(Exists(std::string(folder) + "/reproduce.json"));
  }
}

}  // namespace
}  // namespace sagitta::test::reproduce_test
