#include "problems/io/import/joint_columns.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "problems/io/import/header_words.h"
#include "problems/io/import/mapped_columns.h"
#include "problems/text.h"

namespace sagitta {
namespace {

using Words = std::vector<std::string>;

// Names of all joints of an arm that say their order together; all or none of them.
struct NamedArm {
  std::vector<Words> joints;
};
const std::vector<NamedArm>& ArmsByName() {
  static const std::vector<NamedArm> kArms = {
      {{{"base"}, {"shoulder"}, {"elbow"}, {"wrist", "1"}, {"wrist", "2"}, {"wrist", "3"}}},  // UR's pendant
      {{{"s"}, {"l"}, {"e"}, {"u"}, {"r"}, {"b"}, {"t"}}},  // Yaskawa, of seven axes and of six
      {{{"s"}, {"l"}, {"u"}, {"r"}, {"b"}, {"t"}}}};
  return kArms;
}

// The columns of an arm's joints in their order; empty where one is absent or stands twice.
std::vector<size_t> ColumnsOfArm(const NamedArm& arm, const std::vector<std::string>& headers) {
  std::vector<size_t> columns;
  for (const Words& joint : arm.joints) {
    std::vector<size_t> own;
    for (size_t c = 0; c < headers.size(); ++c) {
      Words words = WordsOf(StemOf(headers[c]));
      if (words.size() > 1 && Has({words.back()}, {"axis", "achse"})) words.pop_back();
      if (words == joint) own.push_back(c);
    }
    if (own.size() != 1) return {};
    columns.push_back(own[0]);
  }
  return columns;
}

// Places of the arm's joints among those of the robot: of one on a rail those that turn; empty where there are fewer.
std::vector<int> PlacesOfArm(size_t count, const std::vector<Joint>& joints) {
  std::vector<int> turning, all;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].type == JointType::kRevolute) turning.push_back(static_cast<int>(j));
  }
  if (turning.size() == count) return turning;
  if (!joints.empty() && joints.size() < count) return {};
  for (size_t j = 0; j < count; ++j) all.push_back(static_cast<int>(j));
  return all;
}

void NameArmsJoints(const std::vector<std::string>& headers, const std::vector<Joint>& joints,
                    std::vector<ColumnMeaning>* meanings) {
  for (const NamedArm& arm : ArmsByName()) {
    const std::vector<size_t> columns = ColumnsOfArm(arm, headers);
    const std::vector<int> places = PlacesOfArm(arm.joints.size(), joints);
    if (columns.empty() || places.empty()) continue;
    for (size_t j = 0; j < columns.size(); ++j) {
      ColumnMeaning meaning;
      meaning.role = Role::kJoint;
      meaning.index = places[j];
      meaning.unit = UnitInHeader(headers[columns[j]]);
      meaning.unread_unit = (*meanings)[columns[j]].unread_unit;
      (*meanings)[columns[j]] = meaning;
    }
    return;
  }
}

// Joints called X, Y, Z, as a gantry's: columns of exactly these names, where others hold the points; all or none.
void NameAxisJoints(const std::vector<std::string>& headers, const std::vector<Joint>& joints,
                    std::vector<ColumnMeaning>* meanings) {
  std::map<size_t, int> joint_of;
  std::set<int> axes_of_points;
  for (size_t c = 0; c < headers.size(); ++c) {
    if ((*meanings)[c].role != Role::kPoint) continue;
    const int joint = JointNamed(headers[c], joints);
    if (joint < 0) axes_of_points.insert((*meanings)[c].index);
    if (joint >= 0) joint_of[c] = joint;
  }
  const auto is_axis = [](const Joint& joint) { return AxisNamed(LowerCaseOf(joint.name)) >= 0; };
  const long expected = std::count_if(joints.begin(), joints.end(), is_axis);
  if (axes_of_points.size() != 3 || static_cast<long>(joint_of.size()) != expected) return;
  SetJoints(joint_of, meanings);
}

// Turning joints that are named by one word and the numbers 1, 2, … in their order: their places; else empty.
std::vector<int> NumberedTurningJoints(const std::vector<Joint>& joints) {
  std::vector<int> places;
  std::string word;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].type != JointType::kRevolute) continue;
    const Words words = WordsOf(joints[j].name);
    if (words.size() != 2 || words[1] != std::to_string(places.size() + 1)) return {};
    if (!places.empty() && words[0] != word) return {};
    word = words[0];
    places.push_back(static_cast<int>(j));
  }
  return places;
}

// Numbers in units of angles count the turning joints, unless there are more of them.
void CountTurningJoints(const std::vector<Joint>& joints, std::vector<ColumnMeaning>* meanings) {
  const std::vector<int> places = NumberedTurningJoints(joints);
  if (places.empty() || places.size() == joints.size()) return;
  std::vector<ColumnMeaning*> numbered;
  for (ColumnMeaning& meaning : *meanings) {
    if (meaning.role != Role::kJoint || !meaning.is_numbered) continue;
    if (!IsAngleUnit(meaning.unit) || meaning.index < 0) return;
    if (meaning.index >= static_cast<int>(places.size())) return;
    numbered.push_back(&meaning);
  }
  for (ColumnMeaning* meaning : numbered) meaning->index = places[static_cast<size_t>(meaning->index)];
}

// Words of an axis that carries the arm, and words that may stand around it.
const std::set<std::string>& RailWords() {
  static const std::set<std::string> kRail = {"rail", "track", "linear", "schiene", "linearachse", "verfahrachse"};
  return kRail;
}

bool IsRail(const Words& words) {
  static const std::set<std::string> kAround = {"axis", "pos", "position", "achse"};
  return Has(words, RailWords()) && std::all_of(words.begin(), words.end(), [](const std::string& word) {
           return RailWords().count(word) + kAround.count(word) > 0;
         });
}

// "Rail [mm]" or "E1 [mm]" of a robot with one joint that slides, where no other column is that joint.
void NameRail(const std::vector<std::string>& headers, const std::vector<Joint>& joints,
              std::vector<ColumnMeaning>* meanings) {
  const auto slides = [](const Joint& joint) { return joint.type == JointType::kPrismatic; };
  if (std::count_if(joints.begin(), joints.end(), slides) != 1) return;
  const int rail = static_cast<int>(std::find_if(joints.begin(), joints.end(), slides) - joints.begin());
  std::vector<size_t> columns;
  for (size_t c = 0; c < headers.size(); ++c) {
    const Words words = WordsOf(StemOf(headers[c]));
    const bool is_rail = IsRail(words);
    const bool is_first_external = words == Words{"e", "1"};
    if ((is_rail || is_first_external) && IsLengthUnit((*meanings)[c].unit)) columns.push_back(c);
    if ((*meanings)[c].role == Role::kJoint && (*meanings)[c].index == rail) return;
  }
  if (columns.size() != 1) return;
  (*meanings)[columns[0]].role = Role::kJoint;
  (*meanings)[columns[0]].index = rail;
}

}  // namespace

int JointNamed(const std::string& header, const std::vector<Joint>& joints) {
  const std::string name = StemOf(header);
  const auto own = std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) { return joint.name == name; });
  return own == joints.end() ? -1 : static_cast<int>(own - joints.begin());
}

void SetJoints(const std::map<size_t, int>& joint_of, std::vector<ColumnMeaning>* meanings) {
  for (const auto& [column, joint] : joint_of) {
    (*meanings)[column].role = Role::kJoint;
    (*meanings)[column].index = joint;
  }
}

bool NamesExternalAxis(const std::string& header) {
  const Words words = WordsOf(StemOf(header));
  if (IsRail(words)) return true;
  const bool is_counted = words.size() == 2 && words[1].size() == 1 && words[1][0] >= '1' && words[1][0] <= '6';
  return is_counted && Has({words[0]}, {"e", "ext", "extax", "eax", "ej"});
}

void NameJointsTogether(const std::vector<std::string>& headers, const std::vector<Joint>& joints,
                        std::vector<ColumnMeaning>* meanings) {
  NameArmsJoints(headers, joints, meanings);
  NameAxisJoints(headers, joints, meanings);
  CountTurningJoints(joints, meanings);
  NameRail(headers, joints, meanings);
}

}  // namespace sagitta
