// The strict reader of JSON: what it refuses, with file and key.
#include "problems/io/json_reader.h"

#include <nlohmann/json.hpp>

#include "tests/problems/file_test_support.h"

namespace sagitta::json_reader_test {
namespace {

using Json = nlohmann::ordered_json;

std::string Refusal(const std::string& text) {
  return ErrorOf([&] { ParseJson(text, "e.json"); });
}

TEST(JsonReaderTest, ReadsWhatIsJson) {
  EXPECT_EQ(ParseJson(R"({"a": [1, 2.5, null], "b": {"a": "]{[\"["}})", "e.json")["b"]["a"], "]{[\"[");
}

TEST(JsonReaderTest, DepthIsLimited) {
  EXPECT_EQ(Refusal(std::string(64, '[') + std::string(64, ']')), "");
  EXPECT_TRUE(SaysInOrder(Refusal("\n" + std::string(65, '[') + std::string(65, ']')), {"e.json:2", "64 deep"}));
  for (const char* open : {"[", "{\"a\":"}) {
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += open;
    EXPECT_TRUE(SaysInOrder(Refusal(deep), {"e.json", "64 deep"}));
  }
}

TEST(JsonReaderTest, WhatIsNoJsonIsRefusedInOurWords) {
  for (const char* text : {"", "{", "[1,]", "{\"a\" 1}", "nan", "[1e999]", "\xFF", "\"\xC3\"", "[1] 2", "// x\n1"}) {
    const std::string error = Refusal(text);
    EXPECT_TRUE(SaysInOrder(error, {"e.json", "not JSON"})) << text;
    EXPECT_EQ(error.find("json.exception"), std::string::npos) << error;
  }
  EXPECT_TRUE(SaysInOrder(Refusal("{\n\"a\": 1,\n oops}"), {"e.json:3"}));
}

TEST(JsonReaderTest, AKeyStandsOnce) {
  EXPECT_TRUE(SaysInOrder(Refusal(R"({"a": {"b": 1, "b": 2}})"), {"e.json", "b:", "twice"}));
  EXPECT_EQ(Refusal(R"({"a": {"b": 1}, "b": {"b": 2}})"), "");
}

class JsonValueTest : public ::testing::Test {
 protected:
  std::string Error(const std::string& text, const std::function<void(const JsonValue&)>& use) {
    json_ = ParseJson(text, "e.json");
    return ErrorOf([&] { use(JsonValue(json_, "e.json")); });
  }
  Json json_;
};

TEST_F(JsonValueTest, ErrorsNameThePlace) {
  const auto number = [](const JsonValue& v) { v.Get("a").Items().at(1).Get("b").Number(); };
  EXPECT_EQ(Error(R"({"a": [0, {"b": 2}]})", number), "");
  EXPECT_TRUE(SaysInOrder(Error(R"({"a": [0, {"b": "2"}]})", number), {"e.json", "a[1].b", "number", "text '2'"}));
  EXPECT_TRUE(SaysInOrder(Error(R"({"a": [0, {}]})", number), {"e.json", "a[1].b", "missing"}));
  EXPECT_TRUE(SaysInOrder(Error(R"({"a": 3})", number), {"e.json", "a:", "list"}));
  EXPECT_TRUE(SaysInOrder(Error("[]", number), {"e.json", "map"}));
}

TEST_F(JsonValueTest, NamesAreTextsAndStandOnce) {
  const auto names = [](const JsonValue& v) { v.Names(); };
  EXPECT_EQ(Error(R"(["a", "b"])", names), "");
  EXPECT_TRUE(SaysInOrder(Error(R"(["a", "b", "a"])", names), {"[2]", "'a'", "twice"}));
  EXPECT_NE(Error(R"(["a", 1])", names), "");
  EXPECT_TRUE(SaysInOrder(Error("[\"a\\u001b[2J\"]", names), {"[0]", "a\\x1b[2J", "control character"}));
  EXPECT_NE(Error("{\"a\\u0000\": 1}", [](const JsonValue& v) { v.Entries(); }), "");
}

TEST_F(JsonValueTest, MatricesHaveTheirShape) {
  const auto matrix = [](const JsonValue& v) { v.Matrix(2, 2, false); };
  EXPECT_EQ(Error("[[1, 2], [3, 4]]", matrix), "");
  for (const char* text : {"[[1, 2]]", "[[1, 2], [3]]", "[[1, 2], [3, 4, 5]]", "[[1, 2], 3]", "{}", "null",
                           "[[1, 2], [3, null]]", "[[1, 2], [3, \"4\"]]", "[[1, 2], [3, 4], [5, 6]]"}) {
    EXPECT_NE(Error(text, matrix), "") << text;
  }
  json_ = ParseJson("[[null, 2]]", "e.json");
  EXPECT_TRUE(std::isnan(JsonValue(json_, "e.json").Matrix(1, 2, true)(0, 0)));
}

TEST_F(JsonValueTest, CorrelationsCanBe) {
  const auto correlation = [](const JsonValue& v) { v.Correlation(static_cast<Eigen::Index>(v.json().size()), false); };
  EXPECT_EQ(Error("[]", correlation), "");
  EXPECT_EQ(Error("[[1, 0.5], [0.5, 1]]", correlation), "");
  EXPECT_EQ(Error("[[1, 1], [1, 1]]", correlation), "");                         // semi-definite
  EXPECT_EQ(Error("[[1, 0.1234567891], [0.12345678905, 1]]", correlation), "");  // cut digits
  EXPECT_TRUE(SaysInOrder(Error("[[1, 1.2], [1.2, 1]]", correlation), {"row 2, column 1", "-1 and 1"}));
  EXPECT_TRUE(SaysInOrder(Error("[[1, 0.5], [0.4, 1]]", correlation), {"other side"}));
  EXPECT_TRUE(SaysInOrder(Error("[[0.9, 0], [0, 1]]", correlation), {"itself"}));
  // Three values each opposed to the two others cannot be: a variance of 1 + 1 + 1 - 2 * 0.9 * 3 < 0.
  EXPECT_TRUE(SaysInOrder(Error("[[1, -0.9, -0.9], [-0.9, 1, -0.9], [-0.9, -0.9, 1]]", correlation), {"variance"}));
}

}  // namespace
}  // namespace sagitta::json_reader_test
