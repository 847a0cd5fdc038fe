#include "problems/io/programs/krl_scene.h"

#include <algorithm>

#include "problems/input_error.h"
#include "problems/io/pattern.h"
#include "problems/io/programs/krl_calls.h"

namespace sagitta {
namespace {

constexpr const char* kHeldInRoom = "#TCP";

KrlVariable VariableOf(const std::string& word) {
  return word == "TOOL" ? kKrlTool : word == "BASE" ? kKrlBase : word == "LOAD" ? kKrlLoad : kKrlMode;
}

}  // namespace

KrlScene::KrlScene(const ProgramCode& code, RobotProgram* program)
    : source_(code), code_(code.text()), program_(*program), flow_(FlowOfKrl(code_)) {
  ReadAllFrameData();
  FindFirstAction();
}

KrlFields KrlScene::FieldsAt(size_t open) const {
  const size_t end = EndOfBracket(code_, open);
  if (end == std::string::npos) {
    throw InputError({program_.path, source_.LineAt(open), ""}, "the brace of this aggregate is not closed");
  }
  size_t begin = open + 1;
  const size_t colon = code_.find(':', begin);
  if (colon < end) begin = colon + 1;
  KrlFields fields;
  for (const TextRange& part : PartsOf(code_, begin, end - 1)) {
    size_t name_end = part.first;
    while (name_end < part.second && IsWordCharacter(code_[name_end])) ++name_end;
    size_t value = name_end;
    while (value < part.second && code_[value] == ' ') ++value;
    fields[code_.substr(part.first, name_end - part.first)] = {value, part.second};
  }
  return fields;
}

std::optional<Pose<double>> KrlScene::PoseAt(size_t open) const {
  const KrlFields fields = FieldsAt(open);
  std::vector<double> numbers;
  for (const char* name : {"X", "Y", "Z", "A", "B", "C"}) {
    const auto field = fields.find(name);
    TextNumber number;
    if (field == fields.end() || !NumberAt(code_, field->second, &number)) return std::nullopt;
    numbers.push_back(number.value);
  }
  return PoseFrom(PoseNotation::kAbcDegrees, numbers);
}

// A mass below 0 is the controller's word for one that nobody has stated.
std::optional<ProgramLoad> KrlScene::LoadAt(size_t open) const {
  const KrlFields fields = FieldsAt(open);
  const auto mass = fields.find("M"), centre = fields.find("CM");
  TextNumber number;
  if (mass == fields.end() || centre == fields.end() || code_[centre->second.first] != '{') return std::nullopt;
  if (!NumberAt(code_, mass->second, &number) || number.value < 0.0) return std::nullopt;
  ProgramLoad load;
  load.mass = number.value;
  const KrlFields of_centre = FieldsAt(centre->second.first);
  for (int a = 0; a < 3; ++a) {
    const auto at = of_centre.find(std::string(1, "XYZ"[a]));
    if (at == of_centre.end() || !NumberAt(code_, at->second, &number)) return std::nullopt;
    load.centre[a] = number.value / 1e3;
  }
  return load;
}

// FDAT of XP1 is FP1; it may stand above its point or below.
void KrlScene::ReadAllFrameData() {
  static const std::regex data = MakeCodePattern("\\bFDAT\\s+(F[\\w$]*)\\s*=\\s*(\\{)");
  for (const std::smatch& match : AllMatches(code_.begin(), code_.end(), data)) {
    frame_data_[match[1]] = FrameDataAt(static_cast<size_t>(match.position(2)));
  }
}

KrlScene::FrameData KrlScene::FrameDataAt(size_t open) const {
  const KrlFields fields = FieldsAt(open);
  const auto number = [&](const char* field, const std::string& stem, const char* zero) -> std::string {
    TextNumber value;
    const auto at = fields.find(field);
    if (at == fields.end() || !NumberAt(code_, at->second, &value) || value.value < 0) return "";
    return value.value == 0 ? zero : stem + "[" + std::to_string(static_cast<int>(value.value)) + "]";
  };
  FrameData data;
  data.tool = number("TOOL_NO", "TOOL_DATA", kFlangeName);
  data.base = number("BASE_NO", "BASE_DATA", kWorldName);
  data.load = number("TOOL_NO", "LOAD_DATA", "");
  const auto mode = fields.find("IPO_FRAME");
  data.is_held = mode != fields.end() && code_.compare(mode->second.first, 4, kHeldInRoom) == 0;
  return data;
}

const KrlScene::FrameData* KrlScene::FindFrameData(const std::string& name) const {
  const auto found = frame_data_.find(name);
  return found == frame_data_.end() ? nullptr : &found->second;
}

void KrlScene::FindFirstAction() {
  static const std::regex action = MakeCodePattern(
      "(?:^|\\n) ?(?:(?:IF|SWITCH|LOOP|FOR|WHILE|REPEAT|GOTO|END|S?PTP|S?LIN|S?CIRC|SPLINE|PTP_SPLINE)\\b|"
      "\\$(?:TOOL|BASE|LOAD)\\b|BAS ?\\( ?#(?!INITMOV)|(?!BAS\\b)\\w+ ?\\(|\\w+ ?: ?\\n)");
  std::smatch match;
  first_action_ = SearchPattern(code_, &match, action) ? static_cast<size_t>(match.position(0)) : code_.size();
  data_begin_ = code_.find("DEFDAT");
  data_end_ = std::min(code_.find("ENDDAT"), code_.size());
}

bool KrlScene::HoldsFromStart(size_t at) const { return at <= first_action_ || (data_begin_ <= at && at < data_end_); }

// A name, or one of a table by its number: NAME, BASE_DATA[2].
bool KrlScene::IsNamed(const std::string& value) const {
  static const std::regex named = MakeCodePattern("^(?:\\$WORLD|\\$ROBROOT|[A-Z_]\\w*(?:\\[\\d+\\])?)$");
  static const std::regex assigned = MakeCodePattern("^(?: ?\\. ?\\w+)* ?=(?!=)");
  if (!MatchPattern(value, named)) return false;
  if (value.back() == ']' || value[0] == '$') return true;
  if (HandedToRoutine(code_, value, false)) return false;
  for (const size_t at : PlacesOf(code_, value)) {
    const std::string behind = code_.substr(at + value.size(), 100);
    if (!HoldsFromStart(at) && SearchPattern(behind, assigned)) return false;
  }
  return true;
}

// MYTOOL = {X 1, ...}, once and above all that runs, states what $TOOL = MYTOOL sets. False: it has no one value.
bool KrlScene::StatePose(KrlVariable variable, const std::string& name) {
  static const std::regex assigned = MakeCodePattern("^(?: ?\\. ?\\w+)* ?=(?!=)"),
                          literal = MakeCodePattern("^ ?= ?\\{");
  int count = 0;
  std::optional<Pose<double>> pose;
  for (const size_t at : PlacesOf(code_, name)) {
    const size_t end = at + name.size();
    const std::string behind = code_.substr(end, 100);
    if (!SearchPattern(behind, assigned)) continue;
    ++count;
    if (SearchPattern(behind, literal)) pose = PoseAt(code_.find('{', end));
  }
  if (name.back() == ']' || count == 0) return true;
  if (count > 1 || !pose) return false;
  (variable == kKrlTool ? program_.tools : program_.frames)[name] = *pose;
  return true;
}

std::optional<std::string> KrlScene::NameOf(KrlVariable variable, const std::string& value, size_t at) {
  const std::string name = Unspaced(value);
  if (name == "$NULLFRAME") return variable == kKrlTool ? kFlangeName : kWorldName;
  if (name[0] != '{') {
    const bool is_clear = IsNamed(name) && (variable == kKrlLoad || StatePose(variable, name));
    return is_clear ? std::make_optional(name) : std::nullopt;
  }
  const std::string word = variable == kKrlTool ? "$TOOL" : variable == kKrlBase ? "$BASE" : "$LOAD";
  const std::string here = word + " of line " + std::to_string(source_.LineAt(at));
  if (variable == kKrlLoad) {
    if (const auto load = LoadAt(at)) loads_.State(here, *load, &program_.loads);
    return here;
  }
  const auto pose = PoseAt(at);
  if (!pose) return std::nullopt;
  (variable == kKrlTool ? program_.tools : program_.frames)[here] = *pose;
  return here;
}

// $TOOL, $BASE or $LOAD = value, $IPO_MODE = #TCP
void KrlScene::Set(const std::string& what, const std::string& value, size_t at) {
  const KrlVariable variable = VariableOf(what);
  is_frame_data_set_ = false;
  if (variable == kKrlMode) {
    flow_.Set(kKrlMode, value == "#BASE" ? "" : value);
  } else {
    const auto name = NameOf(variable, value, at);
    name ? flow_.Set(variable, *name) : flow_.SetUnknown(variable);
  }
}

// BAS(#TOOL, 1) sets the load of the tool, too.
void KrlScene::ReadBas(const std::string& what, const std::string& number) {
  const bool is_number = !number.empty() && number.find_first_not_of("0123456789") == std::string::npos;
  if (what == "INITMOV") {
    // It stands above all that is set; what was set before may be reset.
    for (const KrlVariable v : {kKrlTool, kKrlBase, kKrlLoad}) {
      if (flow_.Of(v) != FlowValues{""}) flow_.SetUnknown(v);
    }
  } else if (what == "TOOL" || what == "BASE") {
    is_frame_data_set_ = false;
    if (!is_number) flow_.SetUnknown(VariableOf(what));
    if (!is_number && what == "TOOL") flow_.SetUnknown(kKrlLoad);
    if (is_number) SetByNumber(what, number);
  } else if (!is_frame_data_set_) {
    SetFrameData("");
  }
}

void KrlScene::SetByNumber(const std::string& kind, const std::string& number) {
  const bool is_tool = kind == "TOOL", is_null = number == "0";
  const std::string place = "[" + number + "]", null_name = is_tool ? kFlangeName : kWorldName;
  flow_.Set(VariableOf(kind), is_null ? null_name : kind + "_DATA" + place);
  if (is_tool) flow_.Set(kKrlLoad, is_null ? "" : "LOAD_DATA" + place);
}

void KrlScene::SetFrameData(const std::string& name) {
  const FrameData* data = FindFrameData(name);
  if (data == nullptr) {
    for (const KrlVariable v : {kKrlTool, kKrlBase, kKrlLoad}) flow_.SetUnknown(v);
    return;
  }
  data->tool.empty() ? flow_.SetUnknown(kKrlTool) : flow_.Set(kKrlTool, data->tool);
  data->base.empty() ? flow_.SetUnknown(kKrlBase) : flow_.Set(kKrlBase, data->base);
  flow_.Set(kKrlLoad, data->load);
  flow_.Set(kKrlMode, data->is_held ? kHeldInRoom : "");
}

// SLIN XP1 WITH $VEL.CP = 0.2, $BASE = BASE_DATA[2]: for this one motion; SPLINE WITH ...: for the block.
void KrlScene::ReadWith(const std::string& line, size_t begin) {
  static const std::regex with = MakeCodePattern("[\\s}\\])E]WITH\\s+(?=\\$)"),
                          set = MakeCodePattern("^\\$(TOOL|BASE|LOAD|IPO_MODE)\\s*=\\s*");
  std::smatch match;
  if (!SearchPattern(line, &match, with)) return;
  const size_t from = begin + static_cast<size_t>(match.position(0) + match.length(0));
  for (const TextRange& part : PartsOf(code_, from, begin + line.size())) {
    const std::string text = code_.substr(part.first, part.second - part.first);
    if (!SearchPattern(text, &match, set)) continue;
    const size_t length = static_cast<size_t>(match.length(0));
    Set(match[1], text.substr(length), part.first + length);
  }
}

// TOOL_DATA[1] = {...}, LOAD_DATA[1] = {...}, DECL LOAD GRIPPER = {...}, GRIPPER = {M 5, CM {...}}
bool KrlScene::ReadData(const std::string& line, size_t begin) {
  static const std::regex data =
      MakeCodePattern("^\\s*\\$?(TOOL|BASE|LOAD)_DATA\\s*\\[\\s*(\\d+)\\s*\\]\\s*=\\s*(\\{)");
  static const std::regex named =
      MakeCodePattern("^\\s*(?:DECL\\s+)?(?:GLOBAL\\s+)?(?:CONST\\s+)?(LOAD\\s+)?(\\w+)\\s*=\\s*(\\{)");
  std::smatch match;
  const bool is_data = SearchPattern(line, &match, data);
  if (!is_data && !SearchPattern(line, &match, named)) return false;
  const size_t open = begin + static_cast<size_t>(match.position(3));
  // A LOAD may be declared in a line of its own, or in another file: its parts say that it is one.
  if (!is_data && !match[1].matched && FieldsAt(open).count("CM") == 0) return false;
  const std::string kind = is_data ? match[1].str() : "LOAD",
                    name = is_data ? kind + "_DATA[" + match[2].str() + "]" : match[2].str();
  const auto state = [&](auto* once, const auto& value, auto* stated) {
    if (!HoldsFromStart(begin) && stated->count(name) == 0) once->Change(name, stated);
    if (value) once->State(name, *value, stated);
  };
  if (kind == "LOAD") state(&loads_, LoadAt(open), &program_.loads);
  if (kind == "TOOL") state(&tools_, PoseAt(open), &program_.tools);
  if (kind == "BASE") state(&bases_, PoseAt(open), &program_.frames);
  return true;
}

void KrlScene::Change(const std::string& kind, const std::string& name) {
  if (kind == "LOAD") loads_.Change(name, &program_.loads);
  if (kind == "TOOL") tools_.Change(name, &program_.tools);
  if (kind == "BASE") bases_.Change(name, &program_.frames);
}

// LOAD_DATA[1].M = 5, TOOL_DATA[2] = X, BASE_DATA[I] = {...}, GRIPPER.CM.X = 10, $TOOL.Z = 3.
bool KrlScene::ReadChange(const std::string& line) {
  static const std::regex change = MakeCodePattern(
      "^\\s*(?:\\$(TOOL|BASE|LOAD)|\\$?(TOOL|BASE|LOAD)_DATA\\s*\\[([^\\]]*)\\]|(\\w+))\\s*((?:\\.\\s*\\w+\\s*)*)"
      "=\\s*(?=\\S)");
  std::smatch match;
  if (!SearchPattern(line, &match, change)) return false;
  if (match[1].matched) {
    if (match.length(5) > 0) flow_.SetUnknown(VariableOf(match[1]));
    return match.length(5) > 0;
  }
  if (match[4].matched) {
    if (program_.loads.count(match[4]) == 0) return false;
    Change("LOAD", match[4]);
    return true;
  }
  const std::string index = Unspaced(match[3]);
  const bool is_number = index.find_first_not_of("0123456789") == std::string::npos;
  const std::string list = match[2].str() + "_DATA[";
  Change(match[2], is_number ? list + index + "]" : list);
  return true;
}

bool KrlScene::ReadLine(const std::string& line, size_t begin) {
  static const std::regex set = MakeCodePattern("^\\s*\\$(TOOL|BASE|LOAD|IPO_MODE)\\s*=\\s*(\\S.*?)\\s*$");
  static const std::regex bas =
      MakeCodePattern("\\bBAS\\s*\\(\\s*#(TOOL|BASE|INITMOV|FRAMES|PTP_PARAMS|CP_PARAMS)\\s*(?:,\\s*([^)]*?)\\s*)?\\)");
  static const std::regex data = MakeCodePattern("^\\s*FDAT_ACT\\s*=\\s*(.*?)\\s*$");
  std::smatch match;
  if (SearchPattern(line, &match, set)) {
    Set(match[1], match[2], begin + static_cast<size_t>(match.position(2)));
    return true;
  }
  if (SearchPattern(line, &match, bas)) {
    ReadBas(match[1], match[2]);
    return true;
  }
  if (SearchPattern(line, &match, data)) {
    SetFrameData(match[1]);
    is_frame_data_set_ = true;
    return true;
  }
  return ReadData(line, begin) || ReadChange(line);
}

void KrlScene::LeaveChanged() const {
  const auto is_changed = [](const auto& once, const std::string& name) {
    return once.IsChanged(name) || once.IsChanged(name.substr(0, name.find('[') + 1));
  };
  for (ProgramPoint& point : program_.points) {
    const bool is_tool = is_changed(tools_, point.tool);
    if (!point.untouched.empty()) continue;
    if (is_tool || is_changed(bases_, point.frame)) {
      point.untouched = "the program changes " + (is_tool ? point.tool : point.frame) + " as it runs";
    } else if (is_changed(loads_, point.load)) {
      point.other_load = kSetElsewhere;
    }
  }
}

}  // namespace sagitta
