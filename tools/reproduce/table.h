// A published table next to what can be computed of it, and a verdict on each row.
//
//   reproduced           within 10 % (or what the row states)
//   order of magnitude   within a factor of 3, or as near as it can be judged where the
//                        configurations or the layout are not printed
//   not reproducible     from what is printed, and why
//   input                drives the simulation: nothing is proved by getting it back
//   not in the paper     what the paper should have printed next to it
#pragma once

#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/report/summary.h"

namespace sagitta {

enum class Reproducibility { kReproduced, kOrderOfMagnitude, kNotReproducible, kInput, kAddition };
const char* ReproducibilityName(Reproducibility verdict);

struct ReproducedRow {
  std::string quantity;
  std::string published, computed;  // as shown
  Reproducibility verdict = Reproducibility::kInput;
  std::string why;  // empty where it goes without saying
  double published_value = std::numeric_limits<double>::quiet_NaN();
  double computed_value = std::numeric_limits<double>::quiet_NaN();
  std::map<std::string, double> numbers;  // behind words, for the JSON
};

struct ReproducedTable {
  std::string id;  // 002-VI
  std::string title;
  std::vector<ReproducedRow> rows;
  std::vector<std::string> notes;
  std::vector<Picture> pictures;  // for the page alone

  int Count(Reproducibility verdict) const;

  // Two numbers, shown with `decimals`; the ratio decides, but never better than `best`.
  ReproducedRow& Compare(const std::string& quantity, double published_value, double computed_value, int decimals,
                         const std::string& why = "", Reproducibility best = Reproducibility::kReproduced);
  // Words; the caller decides.
  ReproducedRow& State(const std::string& quantity, const std::string& published_text, const std::string& computed_text,
                       Reproducibility verdict, const std::string& why = "");
};

// Ratio within 10 %: reproduced; within a factor of 3: order of magnitude.
Reproducibility JudgeRatio(double published, double computed, Reproducibility best = Reproducibility::kReproduced);

// The note on every page.
const std::string& SimulationNote();

Section TableToSection(const ReproducedTable& table);
Section OverviewSection(const std::vector<ReproducedTable>& tables);
nlohmann::ordered_json TableToJson(const ReproducedTable& table);

// One self-contained page; every table under its own heading with the note.
std::string ReproductionToHtml(const std::vector<ReproducedTable>& tables, const std::string& command);

}  // namespace sagitta
