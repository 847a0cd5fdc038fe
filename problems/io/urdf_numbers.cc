#include "problems/io/urdf_numbers.h"

#include <expat.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <vector>

#include "problems/input_error.h"
#include "problems/io/text_checks.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// How many numbers an attribute holds, by element; of others nothing is known.
size_t NumbersOf(const std::string& element, const std::string& attribute) {
  static const std::map<std::string, std::map<std::string, size_t>> kNumbers = {
      {"origin", {{"xyz", 3}, {"rpy", 3}}},
      {"axis", {{"xyz", 3}}},
      {"limit", {{"lower", 1}, {"upper", 1}, {"effort", 1}, {"velocity", 1}}},
      {"mimic", {{"multiplier", 1}, {"offset", 1}}},
      {"dynamics", {{"damping", 1}, {"friction", 1}}},
      {"mass", {{"value", 1}}},
      {"inertia", {{"ixx", 1}, {"ixy", 1}, {"ixz", 1}, {"iyy", 1}, {"iyz", 1}, {"izz", 1}}},
      {"box", {{"size", 3}}},
      {"sphere", {{"radius", 1}}},
      {"cylinder", {{"radius", 1}, {"length", 1}}},
      {"mesh", {{"scale", 3}}}};
  const auto found = kNumbers.find(element);
  if (found == kNumbers.end()) return 0;
  const auto count = found->second.find(attribute);
  return count == found->second.end() ? 0 : count->second;
}

std::optional<double> NumberOf(std::string word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.erase(0, 1);
  return ParseNumber(word);
}

// Joints and links are children of the root; those inside transmissions are not meant.
struct Reader {
  XML_Parser parser = nullptr;
  std::string file;
  std::vector<std::string> path;  // names of the open elements
  std::string owner;              // the joint or link that is open
  std::map<std::string, UrdfJointPlace> places;
  std::unique_ptr<InputError> error;  // expat is no place to throw through

  int Line() const { return static_cast<int>(XML_GetCurrentLineNumber(parser)); }
  bool IsJoint() const { return path.size() > 1 && path[1] == "joint"; }

  // Extensions of simulators have elements of their own.
  bool IsRead() const {
    if (path.size() == 3 && IsJoint()) return true;
    if (path.size() < 4 || path[1] != "link") return false;
    return path[2] == "inertial" || path[2] == "visual" || path[2] == "collision";
  }

  void Start(const XML_Char* element, const XML_Char** attributes) {
    path.emplace_back(element);
    if (error || path.size() < 2) return;
    if (path.size() == 2) Open(attributes);
    if (!IsRead()) return;
    for (; *attributes != nullptr && !error; attributes += 2) Check(attributes[0], attributes[1]);
  }

  void Open(const XML_Char** attributes) {
    owner.clear();
    for (; *attributes != nullptr; attributes += 2) {
      if (std::string(attributes[0]) == "name") owner = attributes[1];
    }
    if (IsJoint()) places[owner].line = Line();
  }

  void Check(const std::string& attribute, const std::string& value) {
    const size_t expected = NumbersOf(path.back(), attribute);
    if (expected == 0) return;
    std::istringstream words(value);
    std::vector<double> numbers;
    for (std::string word; words >> word;) {
      const std::optional<double> number = NumberOf(word);
      if (!number) return Refuse(attribute, value, "'" + Printable(word) + "' is no number");
      numbers.push_back(*number);
    }
    if (numbers.size() != expected) {
      return Refuse(attribute, value,
                    std::to_string(numbers.size()) + " numbers stand where " + std::to_string(expected) +
                        (expected == 1 ? " is" : " are") + " expected");
    }
    if (IsJoint() && path.back() == "origin" && attribute == "rpy")
      places[owner].rpy = Vector3<double>(numbers[0], numbers[1], numbers[2]);
  }

  void Refuse(const std::string& attribute, const std::string& value, const std::string& why) {
    error = std::make_unique<InputError>(
        InputError::Where{file, Line(), owner},
        why + ", in " + attribute + "=\"" + Printable(value.substr(0, 60)) + "\" of <" + path.back() + ">",
        "numbers with blanks between them and a point as decimal sign are expected, in m and rad");
  }
};

}  // namespace

std::map<std::string, UrdfJointPlace> CheckUrdfNumbers(const std::string& text, const std::string& file) {
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  Reader reader;
  reader.parser = parser.get();
  reader.file = file;
  XML_SetUserData(parser.get(), &reader);
  XML_SetElementHandler(
      parser.get(),
      [](void* data, const XML_Char* element, const XML_Char** attributes) {
        static_cast<Reader*>(data)->Start(element, attributes);
      },
      [](void* data, const XML_Char*) { static_cast<Reader*>(data)->path.pop_back(); });
  XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1);  // CheckXml says what is wrong with it
  if (reader.error) throw InputError(*reader.error);
  return reader.places;
}

std::string WithPlainBlanks(std::string text) {
  char quote = 0;
  bool is_tag = false;
  for (size_t i = 0; i < text.size(); ++i) {
    char& c = text[i];
    if (!is_tag && text.compare(i, 4, "<!--") == 0) {
      i = std::min(text.find("-->", i), text.size() - 1);
    } else if (!is_tag && text.compare(i, 9, "<![CDATA[") == 0) {
      i = std::min(text.find("]]>", i), text.size() - 1);
    } else if (quote == 0) {
      is_tag = c == '<' || (is_tag && c != '>');
      if (is_tag && (c == '"' || c == '\'')) quote = c;
    } else if (c == quote) {
      quote = 0;
    } else if (c == '\n' || c == '\r' || c == '\t') {
      c = ' ';
    }
  }
  return text;
}

}  // namespace sagitta
