#include "problems/io/programs/program_flow.h"

#include <algorithm>

#include "problems/io/pattern.h"
#include "problems/io/programs/program_text.h"

namespace sagitta {
namespace {

bool OpensBlock(FlowKind kind) {
  return kind == FlowKind::kRoutine || kind == FlowKind::kBranch || kind == FlowKind::kSwitch ||
         kind == FlowKind::kLoop;
}

bool ClosesBlock(FlowKind kind) {
  return kind == FlowKind::kRoutineEnd || kind == FlowKind::kBranchEnd || kind == FlowKind::kLoopEnd ||
         kind == FlowKind::kEnd;
}

void AddValues(const FlowValues& more, FlowValues* values) { values->insert(more.begin(), more.end()); }

// The statement that begins at `at`, of which a pattern has found `length` bytes, without blanks.
std::string StatementAt(const std::string& code, size_t at, size_t length) {
  const size_t last = at + length - 1;
  const size_t end = code[last] == '(' ? EndOfBracket(code, last) : code.find_first_of(";\n", last + 1);
  return Unspaced(code.substr(at, std::min(end, code.size()) - at));
}

}  // namespace

std::vector<FlowEvent> FlowEventsOf(const std::string& code, const std::regex& pattern,
                                    const std::map<std::string, FlowKind>& kinds) {
  std::vector<FlowEvent> events;
  for (const std::smatch& match : AllMatches(code.begin(), code.end(), pattern)) {
    FlowEvent event;
    event.at = static_cast<size_t>(match.position(1));
    event.kind = kinds.at(match[1]);
    event.name = match[2];
    events.push_back(event);
  }
  return events;
}

std::vector<FlowEvent> WithEndsOfShortBranches(const std::string& code, const std::vector<FlowEvent>& events) {
  static const std::regex then = MakeCodePattern("\\bTHEN\\b");
  std::vector<FlowEvent> with_ends;
  for (const FlowEvent& event : events) {
    with_ends.push_back(event);
    const size_t end = std::min(code.find(';', event.at), code.size());
    if (event.kind != FlowKind::kBranch || SearchPattern(code.substr(event.at, end - event.at), then)) continue;
    with_ends.push_back({end, FlowKind::kBranchEnd, "", 0, false, false});
  }
  return with_ends;
}

ProgramFlow::ProgramFlow(const std::string& code, std::vector<FlowEvent> events,
                         const std::vector<FlowVariable>& variables)
    : events_(std::move(events)), variables_(variables), values_(variables.size(), {""}) {
  for (const FlowVariable& variable : variables_) {
    setters_.emplace_back();
    for (const std::smatch& match : AllMatches(code.begin(), code.end(), variable.setter)) {
      const size_t at = static_cast<size_t>(match.position(0)), length = static_cast<size_t>(match.length(0));
      setters_.back().push_back({at, variable.value_is_text ? Unspaced(match[0]) : StatementAt(code, at, length)});
    }
  }
  std::stable_sort(events_.begin(), events_.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  FindEnds();
  FindCalls(code);
  for (const FlowEvent& event : events_) {
    if (!event.is_interrupt) continue;
    for (const size_t v : SetWithin(event.at, event.until)) interrupted_.insert(v);
  }
  for (const size_t v : interrupted_) AddUnknown(v, kSetElsewhere);
}

void ProgramFlow::FindEnds() {
  std::vector<size_t> open;
  for (size_t i = 0; i < events_.size(); ++i) {
    if (OpensBlock(events_[i].kind)) {
      events_[i].until = std::string::npos;
      open.push_back(i);
    }
    if (!ClosesBlock(events_[i].kind)) continue;
    const bool is_routine = events_[i].kind == FlowKind::kRoutineEnd;
    while (!open.empty()) {
      FlowEvent& opened = events_[open.back()];
      open.pop_back();
      opened.until = events_[i].at;
      if (!is_routine || opened.kind == FlowKind::kRoutine) break;
    }
  }
}

std::set<size_t> ProgramFlow::SetWithin(size_t begin, size_t end) const {
  std::set<size_t> variables;
  for (size_t v = 0; v < setters_.size(); ++v) {
    for (const Setter& setter : setters_[v]) {
      if (setter.at >= begin && setter.at < end) variables.insert(v);
    }
  }
  for (const FlowEvent& event : events_) {
    if (event.kind != FlowKind::kCall || event.at < begin || event.at >= end) continue;
    const std::set<size_t>& called = sets_.at(event.name);
    variables.insert(called.begin(), called.end());
  }
  return variables;
}

// A routine that calls one that sets a variable sets it, too: as often as there are routines, each finds those it
// calls.
void ProgramFlow::FindCalls(const std::string& code) {
  const std::vector<FlowEvent> known = events_;
  std::vector<const FlowEvent*> routines;
  for (const FlowEvent& event : known) {
    if (event.kind == FlowKind::kRoutine && !event.name.empty()) routines.push_back(&event);
  }
  for (const FlowEvent* routine : routines) {
    sets_[routine->name];
    const size_t header = routine->at + code.substr(routine->at).find(routine->name);
    for (const size_t at : PlacesOf(code, routine->name)) {
      if (at != header) events_.push_back({at, FlowKind::kCall, routine->name, 0, false, false});
    }
  }
  std::stable_sort(events_.begin(), events_.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  for (size_t round = 0; round < routines.size(); ++round) {
    const auto before = sets_;
    for (const FlowEvent* routine : routines) {
      const std::set<size_t> within = SetWithin(routine->at, routine->until);
      sets_[routine->name].insert(within.begin(), within.end());
    }
    if (sets_ == before) break;
  }
}

bool ProgramFlow::IsSetAlike(size_t variable) const {
  const std::vector<Setter>& setters = setters_[variable];
  return std::all_of(setters.begin(), setters.end(), [&](const Setter& s) { return s.text == setters[0].text; });
}

void ProgramFlow::MoveTo(size_t position) {
  for (; next_ < events_.size() && events_[next_].at <= position; ++next_) Pass(events_[next_]);
}

void ProgramFlow::Set(size_t variable, const std::string& value) {
  values_[variable] = {value};
  if (interrupted_.count(variable) > 0) AddUnknown(variable, kSetElsewhere);
}

void ProgramFlow::SetAllBut(size_t kept, const std::vector<FlowValues>& values) {
  const FlowValues stays = values_[kept];
  values_ = values;
  values_[kept] = stays;
}

void ProgramFlow::AddUnknown(size_t variable, const char* mark) {
  if (constants_.count(variable) > 0) return;
  if (!variables_[variable].value_is_text) {
    values_[variable].insert(mark);
    return;
  }
  for (const Setter& setter : setters_[variable]) values_[variable].insert(setter.text);
}

// What the main routine has set before anything is called, and every other line sets alike, holds from there on.
void ProgramFlow::FindConstants() {
  if (has_called_ || !IsInMain()) return;
  for (size_t v = 0; v < values_.size(); ++v) {
    const bool is_set = values_[v].size() == 1 && !values_[v].begin()->empty();
    if (is_set && IsSetAlike(v)) constants_[v] = values_[v];
  }
}

bool ProgramFlow::IsInMain() const {
  const auto routine =
      std::find_if(open_.rbegin(), open_.rend(), [](const Block& b) { return b.kind == FlowKind::kRoutine; });
  return routine != open_.rend() && routine->is_main;
}

// A routine sets the one text that there is of the variable, and above all branches.
bool ProgramFlow::AlwaysSets(const std::string& routine, size_t variable) const {
  if (!variables_[variable].value_is_text || !IsSetAlike(variable)) return false;
  const auto head = std::find_if(events_.begin(), events_.end(), [&](const FlowEvent& event) {
    return event.kind == FlowKind::kRoutine && event.name == routine;
  });
  const auto next =
      std::find_if(head + 1, events_.end(), [](const FlowEvent& event) { return event.kind != FlowKind::kCall; });
  if (next == events_.end()) return false;
  return std::any_of(setters_[variable].begin(), setters_[variable].end(),
                     [&](const Setter& setter) { return setter.at > head->at && setter.at < next->at; });
}

// A routine starts with what is set at its calls, where all of them stand above it.
void ProgramFlow::EnterRoutine(const FlowEvent& routine) {
  if (routine.is_main) return;
  bool is_called_above = at_call_.count(routine.name) > 0 && !routine.is_interrupt;
  for (const FlowEvent& event : events_) {
    is_called_above &= event.kind != FlowKind::kCall || event.name != routine.name || event.at < routine.at;
  }
  for (size_t v = 0; v < variables_.size(); ++v) {
    if (setters_[v].empty()) continue;
    if (const auto constant = constants_.find(v); constant != constants_.end()) {
      values_[v] = constant->second;
    } else if (is_called_above) {
      values_[v] = at_call_[routine.name][v];
    } else {
      values_[v] = {""};
      AddUnknown(v, kSetElsewhere);
    }
  }
}

void ProgramFlow::Pass(const FlowEvent& event) {
  const FlowKind kind = event.kind;
  if (OpensBlock(kind)) {
    Block block;
    block.kind = kind;
    block.at_entry = values_;
    block.of_branches.resize(values_.size());
    block.has_branch = kind != FlowKind::kSwitch;
    block.is_main = event.is_main;
    if (kind == FlowKind::kRoutine) FindConstants();
    open_.push_back(block);
    if (kind == FlowKind::kRoutine) EnterRoutine(event);
    if (kind != FlowKind::kLoop) return;
    for (const size_t v : SetWithin(event.at, event.until)) AddUnknown(v, kSetBelow);
  } else if (kind == FlowKind::kMiddle || kind == FlowKind::kElse) {
    if (open_.empty() || open_.back().kind == FlowKind::kRoutine) return;
    EndBranch(&open_.back());
    open_.back().has_branch = true;
    open_.back().has_else |= kind == FlowKind::kElse;
    values_ = open_.back().at_entry;
  } else if (ClosesBlock(kind)) {
    CloseDownTo(kind == FlowKind::kRoutineEnd);
  } else if (kind == FlowKind::kLeave) {
    LeaveLoop();
  } else if (kind == FlowKind::kCall) {
    FindConstants();
    has_called_ = true;
    State& at_call = at_call_[event.name];
    at_call.resize(values_.size());
    for (size_t v = 0; v < values_.size(); ++v) AddValues(values_[v], &at_call[v]);
    for (const size_t v : sets_.at(event.name)) {
      if (constants_.count(v) > 0) continue;
      if (AlwaysSets(event.name, v)) values_[v].clear();
      AddUnknown(v, kSetElsewhere);
    }
  } else {
    for (size_t v = 0; v < values_.size(); ++v) {
      if (!setters_[v].empty()) AddUnknown(v, kSetElsewhere);
    }
  }
}

void ProgramFlow::LeaveLoop() {
  for (auto block = open_.rbegin(); block != open_.rend() && block->kind != FlowKind::kRoutine; ++block) {
    if (block->kind != FlowKind::kLoop) continue;
    EndBranch(&*block);
    return;
  }
}

void ProgramFlow::EndBranch(Block* block) {
  if (!block->has_branch) return;
  for (size_t v = 0; v < values_.size(); ++v) AddValues(values_[v], &block->of_branches[v]);
}

void ProgramFlow::Close(const Block& closed) {
  Block block = closed;
  if (block.kind == FlowKind::kRoutine) {
    values_ = block.at_entry;
    return;
  }
  EndBranch(&block);
  for (size_t v = 0; v < values_.size(); ++v) {
    values_[v] = block.of_branches[v];
    if (!block.has_else) AddValues(block.at_entry[v], &values_[v]);
    // What was set further down in a loop is now behind it.
    if (block.kind == FlowKind::kLoop && block.at_entry[v].count(kSetBelow) == 0) values_[v].erase(kSetBelow);
  }
}

void ProgramFlow::CloseDownTo(bool is_routine) {
  while (!open_.empty()) {
    const Block block = open_.back();
    open_.pop_back();
    Close(block);
    if (!is_routine || block.kind == FlowKind::kRoutine) return;
  }
}

void UseLoads(const FlowValues& loads, bool is_first, ProgramPoint* point) {
  for (const std::string& load : loads) UseLoad(load, is_first && load == *loads.begin(), point);
}

void ComeFrom(const FlowValues& points, ProgramPoint* point) {
  for (const std::string& value : points) {
    const bool is_mark = value == kSetElsewhere || value == kSetBelow;
    point->before.insert(value.empty() ? kPlaceOfStart : is_mark ? kPlaceUnknown : std::stoi(value));
  }
}

}  // namespace sagitta
