#include "problems/io/robot_checks.h"

#include <expat.h>

#include <cmath>
#include <memory>

#include "problems/input_error.h"
#include "problems/io/text_checks.h"
#include "problems/limits.h"

namespace sagitta {
namespace {

constexpr double kRatio = 1e6;  // of a coupling: three gears of a hundred in series

void CheckName(const std::string& name, const std::string& file) {
  if (HasControlCharacter(name)) {
    throw InputError({file, 0, ""}, "the name '" + Printable(name) + "' holds a control character");
  }
}

void CheckTransform(const ElementaryTransform& transform, size_t number, const std::string& file) {
  CheckName(transform.error, file);
  const double most = transform.is_rotation() ? limits::kJointValue : limits::kCoordinate;
  if (std::abs(transform.nominal) <= most) return;  // not so: NaN
  throw InputError({file, 0, ""}, "transform " + std::to_string(number) + " of the chain" +
                                      (transform.error.empty() ? "" : " (" + transform.error + ")") +
                                      " is no length or angle of a robot");
}

struct XmlSize {
  XML_Parser parser = nullptr;
  int depth = 0;
  size_t elements = 0;
  bool is_too_deep = false, is_too_many = false;

  void Start() {
    is_too_deep |= ++depth > limits::kDepth;
    is_too_many |= ++elements > limits::kXmlElements;
    if (is_too_deep || is_too_many) XML_StopParser(parser, XML_FALSE);
  }
};

}  // namespace

void CheckRobot(const Robot& robot, const std::string& file) {
  const Chain& chain = robot.chain;
  if (chain.num_joints() > limits::kJoints) {
    throw InputError({file, 0, ""}, "the chain has " + std::to_string(chain.num_joints()) + " joints, at most " +
                                        std::to_string(limits::kJoints) + " are possible");
  }
  if (chain.num_transforms() > limits::kTransforms) {
    throw InputError({file, 0, ""}, "the chain has more than " + std::to_string(limits::kTransforms) + " transforms");
  }
  CheckName(robot.name, file);
  for (const Joint& joint : chain.joints) CheckName(joint.name, file);
  for (size_t e = 0; e < chain.transforms.size(); ++e) CheckTransform(chain.transforms[e], e + 1, file);
  for (const Coupling& coupling : chain.couplings) {
    if (std::abs(coupling.ratio) <= kRatio) continue;
    throw InputError({file, 0, chain.joints[coupling.joint].name}, "the coupling's ratio is no ratio of gears");
  }
}

void CheckXml(const std::string& text, const std::string& file) {
  if (text.size() > limits::kMarkupBytes) {
    throw InputError({file, 0, ""}, "the file is longer than " + std::to_string(limits::kMarkupBytes >> 20) + " MB");
  }
  const std::unique_ptr<XML_ParserStruct, void (*)(XML_Parser)> parser(XML_ParserCreate(nullptr), XML_ParserFree);
  XmlSize size;
  size.parser = parser.get();
  XML_SetUserData(parser.get(), &size);
  XML_SetElementHandler(
      parser.get(), [](void* data, const XML_Char*, const XML_Char**) { static_cast<XmlSize*>(data)->Start(); },
      [](void* data, const XML_Char*) { --static_cast<XmlSize*>(data)->depth; });
  const bool is_whole = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK;
  const int line = static_cast<int>(XML_GetCurrentLineNumber(parser.get()));
  if (size.is_too_deep) {
    throw InputError({file, line, ""}, "elements are nested more than " + std::to_string(limits::kDepth) + " deep");
  }
  if (size.is_too_many) {
    throw InputError({file, line, ""}, "there are more than " + std::to_string(limits::kXmlElements) + " elements");
  }
  if (is_whole) return;
  throw InputError({file, line, ""},
                   std::string("this is not a valid URDF: ") + XML_ErrorString(XML_GetErrorCode(parser.get())));
}

}  // namespace sagitta
