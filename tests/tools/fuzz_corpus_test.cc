// The seeds of the fuzzers, and whatever once made a reader crash: each is read, or refused with words.
#include <filesystem>
#include <functional>

#include "estimator/results/estimate_json.h"
#include "tests/fuzz/readers.h"
#include "tests/tools/program.h"

namespace sagitta::test::fuzz_corpus_test {
namespace {

TEST(FuzzCorpusTest, EverySeedIsReadOrRefused) {
  const std::map<std::string, std::function<void(const std::string&)>> readers = {
      {"robot", fuzz::ReadRobot},
      {"urdf", fuzz::ReadUrdf},
      {"measurements", fuzz::ReadMeasurements},
      {"experiment", fuzz::ReadExperiment},
      {"foreign_robot", fuzz::ReadForeignRobot},
      {"foreign_table", fuzz::ReadForeignTable},
      {"joined_tables", fuzz::ReadJoinedTables},
      {"number", fuzz::ReadNumber},
      {"expression", fuzz::ReadExpression},
      {"csv", fuzz::ReadCsv},
      {"json", fuzz::ReadJson},
      {"estimate", [](const std::string& text) { ReadEstimateText(text, "estimate.json"); }}};
  std::map<std::string, int> read;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(SourceFolder() + "/tests/fuzz/corpus")) {
    if (!entry.is_regular_file()) continue;
    const std::string reader = entry.path().parent_path().filename();
    ASSERT_EQ(readers.count(reader), 1u) << entry.path();
    try {
      readers.at(reader)(ReadAll(entry.path()));
      ++read[reader];
    } catch (const InputError&) {  // with words
    } catch (const std::exception& error) {
      ADD_FAILURE() << entry.path() << ": " << error.what();
    }
  }
  for (const auto& [reader, unused] : readers) EXPECT_GT(read[reader], 0) << reader;
}

}  // namespace
}  // namespace sagitta::test::fuzz_corpus_test
