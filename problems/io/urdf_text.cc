#include "problems/io/urdf_text.h"

#include <expat.h>

#include <memory>
#include <optional>
#include <vector>

#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/limits.h"
#include "problems/text.h"

namespace sagitta {
namespace {

struct Span {
  size_t begin = 0;
  size_t length = 0;
};

struct JointPlace {
  Span start_tag;
  std::optional<Span> origin;
};

// Joints are children of the root; those inside transmissions are not meant.
struct Finder {
  XML_Parser parser = nullptr;
  int depth = 0;
  std::string joint;
  std::map<std::string, JointPlace> places;

  Span Here() const {
    return {static_cast<size_t>(XML_GetCurrentByteIndex(parser)), static_cast<size_t>(XML_GetCurrentByteCount(parser))};
  }

  void Start(const std::string& tag, const XML_Char** attributes) {
    ++depth;
    if (depth == 2) joint = tag == "joint" ? NameOf(attributes) : "";
    if (joint.empty()) return;
    if (depth == 2) places[joint].start_tag = Here();
    if (depth == 3 && tag == "origin") places[joint].origin = Here();
  }

  static std::string NameOf(const XML_Char** attributes) {
    for (; *attributes != nullptr; attributes += 2) {
      if (std::string(attributes[0]) == "name") return attributes[1];
    }
    return "";
  }
};

std::map<std::string, JointPlace> FindJoints(const std::string& text, const std::string& file) {
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  Finder finder;
  finder.parser = parser.get();
  XML_SetUserData(parser.get(), &finder);
  XML_SetElementHandler(
      parser.get(),
      [](void* data, const XML_Char* tag, const XML_Char** attributes) {
        static_cast<Finder*>(data)->Start(tag, attributes);
      },
      [](void* data, const XML_Char*) { --static_cast<Finder*>(data)->depth; });
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) != XML_STATUS_OK) {
    throw InputError({file, static_cast<int>(XML_GetCurrentLineNumber(parser.get())), ""},
                     std::string("the URDF's text is not XML: ") + XML_ErrorString(XML_GetErrorCode(parser.get())));
  }
  return finder.places;
}

// The tag with the attribute's value replaced, or with the attribute added in front.
std::string WithAttribute(const std::string& tag, const std::string& name,
                          const std::optional<Vector3<double>>& value) {
  if (!value) return tag;
  const std::regex attribute = MakePattern("(\\s" + name + "\\s*=\\s*)(\"[^\"]*\"|'[^']*')");
  const std::string quoted = "\"" + UrdfNumbers(*value) + "\"";
  if (SearchPattern(tag, attribute)) return ReplacePattern(tag, attribute, "$1" + quoted);
  const std::string element = "<origin";
  return element + " " + name + "=" + quoted + tag.substr(element.size());
}

std::string EditedTag(const std::string& tag, const OriginEdit& edit) {
  return WithAttribute(WithAttribute(tag, "rpy", edit.rpy), "xyz", edit.xyz);
}

// A line break and the blanks of the joint's own line, one level deeper.
std::string IndentAfter(const std::string& text, const Span& joint) {
  const size_t line = text.rfind('\n', joint.begin);
  const size_t first = line == std::string::npos ? 0 : line + 1;
  const std::string blanks = text.substr(first, joint.begin - first);
  return blanks.find_first_not_of(" \t") == std::string::npos ? "\n" + blanks + "  " : "";
}

}  // namespace

std::string UrdfNumbers(const Vector3<double>& v) {
  return FormatNumber(v.x()) + " " + FormatNumber(v.y()) + " " + FormatNumber(v.z());
}

std::string WithOrigins(const std::string& text, const std::string& file,
                        const std::map<std::string, OriginEdit>& edits) {
  const std::map<std::string, JointPlace> places = FindJoints(text, file);
  std::map<size_t, std::pair<size_t, std::string>, std::greater<size_t>> replacements;  // from the end
  for (const auto& [joint, edit] : edits) {
    const JointPlace& place = places.at(joint);
    if (place.origin) {
      const Span& span = *place.origin;
      if (span.length > limits::kWordBytes) {
        throw InputError({file, 0, joint}, "the joint's origin is " + std::to_string(span.length) + " bytes long");
      }
      replacements[span.begin] = {span.length, EditedTag(text.substr(span.begin, span.length), edit)};
    } else {
      const size_t after = place.start_tag.begin + place.start_tag.length;
      replacements[after] = {0, IndentAfter(text, place.start_tag) + EditedTag("<origin/>", edit)};
    }
  }
  std::string edited = text;
  for (const auto& [begin, replacement] : replacements) edited.replace(begin, replacement.first, replacement.second);
  return edited;
}

}  // namespace sagitta
