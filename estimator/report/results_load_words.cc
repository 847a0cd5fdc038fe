#include "estimator/report/results_load_words.h"

#include "problems/text.h"

namespace sagitta {
namespace {

std::string Points(int number) { return std::to_string(number) + (number == 1 ? " point" : " points"); }

std::string Named(const std::string& name) { return name.empty() ? "none" : name; }

}  // namespace

std::string LoadUsedInWords(const std::string& name, const ProgramLoad& load, int points) {
  const Vector3<double> mm = 1e3 * load.centre;
  return "load at " + Points(points) + ": " + name + ", " + Significant(load.mass, 4) + " kg at (" +
         Significant(mm.x(), 4) + ", " + Significant(mm.y(), 4) + ", " + Significant(mm.z(), 4) +
         ") mm of the controller's flange; --load=NAME uses one of the estimate instead";
}

std::string LoadUnknownInWords(const std::string& name, int points) {
  return "the program names the load " + name + " at " + Points(points) +
         " and does not state it: they are corrected for the load 'none' of the estimate; --loads_kg_mm='" + name +
         "=mass,x,y,z' (centre of mass in the controller's flange) states it, --load=NAME uses one of the estimate";
}

std::string LoadOfTwoInWords(const std::string& one, const std::string& other) {
  return "the program moves to it with more than one load (" + Named(one) + " and " + Named(other) +
         "): --load=NAME corrects it for one of the estimate";
}

std::string ToolReplacedInWords(double tool_mass) {
  return "a load that a program states holds the tool, so the tool of the estimate (" + Significant(tool_mass, 3) +
         " kg) is not added to it";
}

}  // namespace sagitta
