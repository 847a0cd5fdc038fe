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

std::string SetterText(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }),
             text.end());
  return text;
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

ProgramFlow::ProgramFlow(const std::string& code, std::vector<FlowEvent> events,
                         const std::vector<FlowVariable>& variables)
    : events_(std::move(events)), variables_(variables), values_(variables.size(), {""}), last_(variables.size()) {
  for (const FlowVariable& variable : variables_) {
    setters_.emplace_back();
    for (const std::smatch& match : AllMatches(code.begin(), code.end(), variable.setter)) {
      setters_.back().push_back({static_cast<size_t>(match.position(0)), SetterText(match[0])});
    }
  }
  FindEnds();
  FindCalls(code);
}

void ProgramFlow::FindEnds() {
  std::vector<size_t> open;
  for (size_t i = 0; i < events_.size(); ++i) {
    events_[i].until = std::string::npos;
    if (OpensBlock(events_[i].kind)) open.push_back(i);
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
      if (at != header) events_.push_back({at, FlowKind::kCall, routine->name, 0, false});
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

// What the whole file sets to one value, and before the first call, is that value in every routine.
void ProgramFlow::EnterRoutine(const FlowEvent& routine) {
  if (routine.is_main) return;
  size_t first_call = std::string::npos;
  for (const FlowEvent& event : events_) {
    if (event.kind == FlowKind::kCall && event.name == routine.name) first_call = std::min(first_call, event.at);
  }
  for (size_t v = 0; v < variables_.size(); ++v) {
    if (setters_[v].empty()) continue;
    const bool is_before = first_call != std::string::npos && setters_[v][0].at < first_call;
    if (IsSetAlike(v) && variables_[v].value_is_text) {
      values_[v] = {setters_[v][0].text};
    } else if (IsSetAlike(v) && is_before && !last_[v].empty()) {
      values_[v] = last_[v];
    } else {
      values_[v] = variables_[v].unknown;
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
    open_.push_back(block);
    if (kind == FlowKind::kRoutine) EnterRoutine(event);
    if (kind != FlowKind::kLoop) return;
    for (const size_t v : SetWithin(event.at, event.until)) values_[v].insert(kSetElsewhere);
  } else if (kind == FlowKind::kMiddle || kind == FlowKind::kElse) {
    if (open_.empty() || open_.back().kind == FlowKind::kRoutine) return;
    EndBranch(&open_.back());
    open_.back().has_branch = true;
    open_.back().has_else |= kind == FlowKind::kElse;
    values_ = open_.back().at_entry;
  } else if (ClosesBlock(kind)) {
    CloseDownTo(kind == FlowKind::kRoutineEnd);
  } else if (kind == FlowKind::kCall) {
    for (const size_t v : sets_.at(event.name)) {
      const bool is_one = variables_[v].value_is_text && IsSetAlike(v);
      values_[v] = is_one ? FlowValues{setters_[v][0].text} : variables_[v].unknown;
    }
  } else {
    for (size_t v = 0; v < values_.size(); ++v) {
      if (!setters_[v].empty()) values_[v].insert(kSetElsewhere);
    }
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
    if (block.kind == FlowKind::kLoop && values_[v].size() > 1 && block.at_entry[v].count(kSetElsewhere) == 0) {
      values_[v].erase(kSetElsewhere);
    }
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

}  // namespace sagitta
