#include "problems/io/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "problems/input_error.h"
#include "problems/io/files.h"
#include "problems/io/text_checks.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kMostQuoted = 60;

// Its beginning: another kind of file is one long text to YAML.
std::string QuotedBeginning(const std::string& text) {
  if (text.size() <= kMostQuoted) return "'" + text + "'";
  size_t end = kMostQuoted;
  while (end > 0 && (text[end] & 0xC0) == 0x80) --end;  // not within a character of UTF-8
  return "'" + text.substr(0, end) + "…'";
}

std::string KindOfYaml(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a list";
  if (node.IsNull()) return "empty";
  return QuotedBeginning(node.Scalar());
}

// "a_cm" or plain "a" where a_mm is meant.
bool IsStemOf(const std::string& stem, const std::string& key) {
  return key == stem || (key.size() > stem.size() && key.compare(0, stem.size(), stem) == 0 &&
                         key[stem.size()] == '_' && key.find('_', stem.size() + 1) == std::string::npos);
}

// "!degrees 90" is 90 of something else: a tag says so to a program that knows it. Those of YAML itself say nothing
// new.
void CheckTag(const YAML::Node& node, const std::string& file, int line) {
  const std::string& tag = node.Tag();
  if (tag.empty() || tag == "?" || tag == "!" || tag.rfind("tag:yaml.org,2002:", 0) == 0) return;
  throw InputError({file, line, ""}, "the tag " + Printable(tag.substr(0, kMostQuoted)) + " is not known here",
                   "state the value without it, in the unit that the key names");
}

// Aliases count as often as they stand for something: a kilobyte of them can stand for 10^9 values. One that holds
// itself has no end.
void CheckTree(const YAML::Node& node, const std::string& file, int depth, size_t* values) {
  const int line = node.Mark().line + 1;
  CheckTag(node, file, line);
  if (depth > limits::kDepth) {
    throw InputError({file, line, ""},
                     "lists and maps are nested more than " + std::to_string(limits::kDepth) + " deep");
  }
  if (++*values > limits::kYamlValues) {
    throw InputError({file, line, ""},
                     "the file stands for more than " + std::to_string(limits::kYamlValues) + " values",
                     "are aliases (*name) nested?");
  }
  if (node.IsScalar()) {
    const size_t found = FindControlCharacter(node.Scalar());
    if (found == std::string::npos) return;
    throw InputError({file, line, ""}, "the text '" + Printable(node.Scalar().substr(0, kMostQuoted)) +
                                           "' holds the control character " +
                                           NameOfControlCharacter(node.Scalar(), found));
  }
  for (const auto& entry : node) {
    if (node.IsSequence()) {
      CheckTree(entry, file, depth + 1, values);
    } else {
      CheckTree(entry.first, file, depth + 1, values);
      CheckTree(entry.second, file, depth + 1, values);
    }
  }
}

void CheckText(const std::string& text, const std::string& file) {
  if (text.size() > limits::kMarkupBytes) {
    throw InputError({file, 0, ""}, "the file is longer than " + std::to_string(limits::kMarkupBytes >> 20) +
                                        " MB: a robot or an experiment is much shorter");
  }
  if (const int line = LineOfInvalidUtf8(text)) throw InputError({file, line, ""}, "this is not a text in UTF-8");
}

}  // namespace

YamlValue::YamlValue(const YAML::Node& node, std::string file, std::string path, int line)
    : node_(node), file_(std::move(file)), path_(std::move(path)), line_(line) {}

void YamlValue::Fail(const std::string& what, const std::string& hint) const {
  throw InputError({file_, line_, path_}, what, hint);
}

void YamlValue::FailAt(int line, const std::string& key, const std::string& what, const std::string& hint) const {
  throw InputError({file_, line > 0 ? line : line_, PathTo(key)}, what, hint);
}

void CheckIn(const Range& range, double si, const YamlValue& at) {
  if (!range.Has(si)) at.Fail(range.Refusal(si));
}

std::string YamlValue::Text() const {
  if (!node_.IsScalar() || node_.Scalar().empty()) Fail("a text is expected, this is " + KindOfYaml(node_));
  return node_.Scalar();
}

double YamlValue::Number() const {
  const std::optional<double> number = node_.IsScalar() ? ParseNumber(node_.Scalar()) : std::nullopt;
  if (!number) Fail("a finite number is expected, this is " + KindOfYaml(node_));
  if (std::abs(*number) > limits::kYamlNumber) Fail(KindOfYaml(node_) + " is too large to compute with");
  return *number;
}

double YamlValue::PositiveNumber() const {
  const double number = Number();
  if (number <= 0.0) Fail("a number above 0 is expected, this is " + KindOfYaml(node_));
  return number;
}

unsigned long long YamlValue::Count() const {
  const std::string text = node_.IsScalar() ? node_.Scalar() : "";
  unsigned long long count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
    Fail("a whole number from 0 is expected, this is " + KindOfYaml(node_));
  }
  return count;
}

bool YamlValue::Flag() const {
  if (Is("true") || Is("True") || Is("yes")) return true;
  if (Is("false") || Is("False") || Is("no")) return false;
  Fail("true or false is expected, this is " + KindOfYaml(node_));
}

std::string YamlValue::OneOf(const std::vector<std::string>& words) const {
  const std::string text = Text();
  if (std::find(words.begin(), words.end(), text) != words.end()) return text;
  Fail(QuotedBeginning(text) + " is not known here", SpellingHint(text, words));
}

std::vector<YamlValue> YamlValue::Items() const {
  if (!node_.IsSequence()) Fail("a list is expected, this is " + KindOfYaml(node_));
  std::vector<YamlValue> items;
  for (const YAML::Node& item : node_) {
    items.emplace_back(item, file_, path_ + "[" + std::to_string(items.size()) + "]", item.Mark().line + 1);
  }
  return items;
}

std::vector<std::string> YamlValue::Texts() const {
  std::vector<std::string> texts;
  for (const YamlValue& item : Items()) {
    const std::string text = item.Text();
    if (std::find(texts.begin(), texts.end(), text) != texts.end()) item.Fail("'" + text + "' is listed twice");
    texts.push_back(text);
  }
  return texts;
}

Vector3<double> YamlValue::Triple(const Unit& unit) const {
  const std::vector<YamlValue> items = Items();
  if (items.size() != 3) Fail("three numbers are expected, this has " + std::to_string(items.size()));
  return {items[0].NumberIn(unit), items[1].NumberIn(unit), items[2].NumberIn(unit)};
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::Entries() const {
  if (!node_.IsMap()) {
    Fail("a map (key: value) is expected, this is " + KindOfYaml(node_),
         path_.empty() ? "a robot or an experiment in YAML belongs here" : "");
  }
  std::vector<std::pair<std::string, YamlValue>> entries;
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const int line = entry.first.Mark().line + 1;
    if (!entry.first.IsScalar()) FailAt(line, "", "a key has to be a plain text", "");
    const std::string& key = entry.first.Scalar();
    if (!seen.insert(key).second) FailAt(line, key, "this key stands here twice", "");
    entries.emplace_back(key, YamlValue(entry.second, file_, PathTo(key), line));
  }
  return entries;
}

namespace {

// Where the reading ended, the cause may stand before.
std::string HintForBadYaml(const std::string& text, int line) {
  const std::vector<std::string> lines = SplitText(text, '\n');
  const int last = std::min(line + 1, static_cast<int>(lines.size()));
  for (int i = 0; i < last; ++i) {
    const size_t first = lines[i].find_first_not_of(" \t");
    if (first != std::string::npos && lines[i].find('\t') < first)
      return "line " + std::to_string(i + 1) + " begins with a tab: YAML is indented with blanks";
  }
  return "look in this line and the one before: a blank after each colon, the same indent for the keys of one map, "
         "brackets and quotes closed";
}

}  // namespace

YamlValue ParseYaml(const std::string& text, const std::string& file) {
  CheckText(text, file);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    for (size_t k = 1; k < documents.size(); ++k) {
      if (documents[k].IsNull() || !documents.front().IsMap()) continue;  // a list is no file of ours as it is
      throw InputError({file, documents[k].Mark().line + 1, ""}, "a second document begins here, behind ---",
                       "one file, one document: remove the ---, or what is behind it");
    }
    const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
    if (root.IsNull()) throw InputError({file, 0, ""}, "the file is empty");
    size_t values = 0;
    CheckTree(root, file, 0, &values);
    return YamlValue(root, file, "", root.Mark().line + 1);
  } catch (const YAML::Exception& error) {
    throw InputError({file, error.mark.line + 1, ""}, "this is not YAML, from here on at the latest",
                     HintForBadYaml(text, error.mark.line));
  }
}

void ListLines(const YamlValue& value, std::map<std::string, int>* lines) {
  if (!value.IsMap()) return;
  for (const auto& [key, entry] : value.Entries()) {
    (*lines)[value.PathTo(key)] = entry.line();
    ListLines(entry, lines);
  }
}

namespace {

double InRange(const YamlValue& value, double si, Dimension dimension) {
  const bool is_angle = dimension == Dimension::kAngle;
  const double most = is_angle ? limits::kJointValue : limits::kCoordinate;
  if (std::abs(si) <= most) return si;
  value.Fail("this is more than " + FormatNumber(is_angle ? most : most / 1e3) + (is_angle ? " rad" : " km"));
}

}  // namespace

YamlMap::YamlMap(const YamlValue& value) : value_(value), entries_(value.Entries()) {}

std::optional<YamlValue> YamlMap::Find(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  for (const auto& [name, value] : entries_) {
    if (name == key) return value;
  }
  return std::nullopt;
}

YamlValue YamlMap::Get(const std::string& key) {
  std::optional<YamlValue> value = Find(key);
  if (!value) FailMissing(key, "");
  return *value;
}

std::optional<YamlMap::Quantity> YamlMap::FindQuantity(const std::string& stem, Dimension dimension) {
  groups_.push_back({stem, dimension});
  std::optional<Quantity> found;
  for (const Unit& unit : UnitsOf(dimension)) {
    const std::optional<YamlValue> value = Find(stem + "_" + unit.suffix);
    if (!value) continue;
    if (found) value->Fail("'" + stem + "' is given in two units", "keep one of them");
    found = Quantity{*value, unit};
  }
  return found;
}

YamlMap::Quantity YamlMap::GetQuantity(const std::string& stem, Dimension dimension) {
  std::optional<Quantity> quantity = FindQuantity(stem, dimension);
  if (!quantity) FailMissing(stem + "_" + UnitsOf(dimension).front().suffix, NamesWithUnits(stem, dimension));
  return *quantity;
}

std::optional<double> YamlMap::Find(const std::string& stem, Dimension dimension) {
  const std::optional<Quantity> quantity = FindQuantity(stem, dimension);
  if (!quantity) return std::nullopt;
  return InRange(quantity->value, quantity->value.NumberIn(quantity->unit), dimension);
}

std::optional<Vector3<double>> YamlMap::FindTriple(const std::string& stem, Dimension dimension) {
  const std::optional<Quantity> quantity = FindQuantity(stem, dimension);
  if (!quantity) return std::nullopt;
  const Vector3<double> triple = quantity->value.Triple(quantity->unit);
  InRange(quantity->value, triple.cwiseAbs().maxCoeff(), dimension);
  return triple;
}

double YamlMap::GetLength(const std::string& stem) {
  const Quantity quantity = GetQuantity(stem, Dimension::kLength);
  return InRange(quantity.value, quantity.value.NumberIn(quantity.unit), Dimension::kLength);
}

double YamlMap::GetAngle(const std::string& stem) {
  const Quantity quantity = GetQuantity(stem, Dimension::kAngle);
  return InRange(quantity.value, quantity.value.NumberIn(quantity.unit), Dimension::kAngle);
}

void YamlMap::ExpectSchema(const std::string& schema) {
  const YamlValue value = Get("schema");
  if (!value.Is(schema)) value.Fail("'" + value.Text() + "' cannot be read here", "expected: " + schema);
}

void YamlMap::Finish() const {
  for (const auto& [key, value] : entries_) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) FailUnknown(key, value);
  }
}

void YamlMap::FailUnknown(const std::string& key, const YamlValue& at) const {
  for (const UnitGroup& group : groups_) {
    if (!IsStemOf(group.stem, key)) continue;
    const std::string what = key == group.stem ? "the key has to name its unit" : "this unit is not allowed here";
    at.Fail(what, "allowed: " + NamesWithUnits(group.stem, group.dimension));
  }
  at.Fail("unknown key '" + key + "'", SpellingHint(key, known_));
}

void YamlMap::FailMissing(const std::string& key, const std::string& spellings) const {
  // A misspelt key explains the missing one. Another letter is another quantity, which may be asked for later.
  for (const auto& [name, value] : entries_) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    if (IsAnotherLetter(name, key) || IsAnotherLetter(name, NearestName(name, known_))) continue;
    for (const UnitGroup& group : groups_) {
      if (IsStemOf(group.stem, name)) FailUnknown(name, value);
    }
    if (NameDistance(name, key) >= 0 || !NearestName(name, known_).empty()) FailUnknown(name, value);
  }
  value_.FailAt(0, key, "this key is missing", spellings.empty() ? "" : "allowed: " + spellings);
}

}  // namespace sagitta
