// A hidden effect: what it is called in FORMATS section 5, its size, and what it
// does to the believed model (some effects are hidden by leaving something out).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/hidden_effects/generator/design.h"

namespace hidden {

// Effects outside the catalogue have no target in FORMATS' terms.
struct HiddenEffect {
  std::string kind;
  bool in_catalogue = true;
  std::string target;
  std::map<std::string, std::string> settings;
  std::vector<std::pair<std::string, double>> parameters;  // in the units of FORMATS section 5
  std::string words;                                       // of effects outside the catalogue
  // Harmonics of the same gear that come with the main one; naming them too is right.
  std::vector<int> further_orders;
};

// What the believed model leaves out.
struct LeftOut {
  std::vector<std::string> errors;       // held at nominal
  std::vector<std::string> compliances;  // rigid
};

std::vector<std::string> CatalogueKinds();
std::vector<std::string> OutsideKinds();
std::vector<std::string> ForeignKinds();
std::vector<std::string> StrangerKinds();
std::vector<std::string> NewcomerKinds();
std::vector<std::string> LatecomerKinds();

// Draws target and shape, sets it to `scale` times a typical size, adds it to
// nature. Throws for a kind that is not known.
HiddenEffect Hide(const std::string& kind, double scale, const RobotKind& robot, const Design& design, Stream* random,
                  Nature* nature, LeftOut* left_out);

// The same for effects outside the catalogue.
HiddenEffect HideOutside(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                         Stream* random, Nature* nature);

// The same for causes outside the catalogue that real cells have.
HiddenEffect HideForeign(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                         Stream* random, Nature* nature);
HiddenEffect HideStranger(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                          Stream* random, Nature* nature);
HiddenEffect HideNewcomer(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                          Stream* random, Nature* nature);
HiddenEffect HideLatecomer(const std::string& kind, double scale, const RobotKind& robot, const Design& design,
                           Stream* random, Nature* nature);

// Any revolute joint.
int RevoluteJoint(const RobotKind& robot, Stream* random);

}  // namespace hidden
