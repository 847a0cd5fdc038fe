// YAML with manners: every refusal names file, line and key; a map knows which
// of its keys were asked for and refuses the others with the nearest spelling.
//
//   YamlMap map(ParseYaml(text, file));
//   const std::string name = map.Get("name").Text();
//   const std::optional<double> a = map.Length("a");  // a_mm or a_m, in m
//   map.Finish();                                     // unknown keys
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "models/geometry.h"
#include "problems/io/units.h"
#include "problems/range.h"

namespace sagitta {

class YamlValue {
 public:
  YamlValue(const YAML::Node& node, std::string file, std::string path, int line);

  bool IsMap() const { return node_.IsMap(); }
  bool IsList() const { return node_.IsSequence(); }
  bool IsNull() const { return node_.IsNull(); }
  // A plain text that is the given word.
  bool Is(const std::string& word) const { return node_.IsScalar() && node_.Scalar() == word; }

  // All of these throw InputError when the value is something else.
  std::string Text() const;  // not empty
  double Number() const;     // finite
  double PositiveNumber() const;
  double NumberIn(const Unit& unit) const { return unit.ToSi(Number()); }
  unsigned long long Count() const;
  bool Flag() const;
  std::string OneOf(const std::vector<std::string>& words) const;
  std::vector<YamlValue> Items() const;
  std::vector<std::string> Texts() const;  // a list, no text twice
  Vector3<double> Triple(const Unit& unit) const;
  std::vector<std::pair<std::string, YamlValue>> Entries() const;  // a map, no key twice

  [[noreturn]] void Fail(const std::string& what, const std::string& hint = "") const;
  [[noreturn]] void FailAt(int line, const std::string& key, const std::string& what, const std::string& hint) const;
  int line() const { return line_; }
  std::string PathTo(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

 private:
  YAML::Node node_;
  std::string file_;
  std::string path_;  // from the root, for messages: kinematics.dh.links[2]
  int line_ = 0;
};

YamlValue ParseYaml(const std::string& text, const std::string& file);

// Refuses, at the value that it was read from, a number (SI) that the range does not have.
void CheckIn(const Range& range, double si, const YamlValue& at);

// The line of every key below `value` by its path from the root: estimate.compliance.
void ListLines(const YamlValue& value, std::map<std::string, int>* lines);

class YamlMap {
 public:
  explicit YamlMap(const YamlValue& value);

  const YamlValue& value() const { return value_; }
  std::optional<YamlValue> Find(const std::string& key);
  YamlValue Get(const std::string& key);  // absent: InputError

  // A value whose unit is in its key; two units for one stem are refused.
  struct Quantity {
    YamlValue value;
    Unit unit;
  };
  std::optional<Quantity> FindQuantity(const std::string& stem, Dimension dimension);
  Quantity GetQuantity(const std::string& stem, Dimension dimension);
  std::optional<double> Find(const std::string& stem, Dimension dimension);
  std::optional<Vector3<double>> FindTriple(const std::string& stem, Dimension dimension);
  std::optional<double> Length(const std::string& stem) { return Find(stem, Dimension::kLength); }
  std::optional<double> Angle(const std::string& stem) { return Find(stem, Dimension::kAngle); }
  double GetLength(const std::string& stem);
  double GetAngle(const std::string& stem);

  // Checks `schema: <name>`.
  void ExpectSchema(const std::string& schema);
  // Throws at the first key that was never asked for.
  void Finish() const;

 private:
  struct UnitGroup {
    std::string stem;
    Dimension dimension;
  };
  [[noreturn]] void FailUnknown(const std::string& key, const YamlValue& at) const;
  [[noreturn]] void FailMissing(const std::string& key, const std::string& spellings) const;

  YamlValue value_;
  std::vector<std::pair<std::string, YamlValue>> entries_;
  std::vector<std::string> known_;  // in the order asked for
  std::vector<UnitGroup> groups_;
};

}  // namespace sagitta
