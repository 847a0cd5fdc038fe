// What an estimate says to people: the same sections for the terminal and for
// report.html.
#pragma once

#include <string>
#include <vector>

#include "estimator/estimate/estimate.h"
#include "estimator/estimate/parameter_table.h"
#include "problems/calibration_problem.h"
#include "problems/text.h"
#include "tools/report/picture.h"

namespace sagitta {

struct Section {
  std::string title;
  std::vector<std::string> paragraphs;
  std::vector<std::string> header;             // of the table; empty: none
  std::vector<std::vector<std::string>> rows;  // the first cell of a row is text, the others numbers
  std::vector<Picture> pictures = {};          // for pages only
  bool folded = false;                         // on a page it opens when asked to
};

// model_error: factor by which it has widened the intervals of the estimate's table (Trust); 1: not at all.
std::vector<Section> Summarise(const CalibrationProblem& problem, const Estimate& estimate, double model_error = 1.0);
// A length in m as a number of mm.
std::string Millimetres(double metres, int decimals = 4);
// Decimals that show two digits of `size`.
int DecimalsFor(double size);
// A unit of results as people write it: "urad" as "µrad".
std::string ShownUnit(const std::string& unit);
// As paper 002, Tables IV and XI.
Section ResidualSection(const std::string& title, const ResidualSize& before, const ResidualSize& after);

// "1 station", "2 stations".
std::string Plural(int n, const std::string& noun);

std::string SectionsToText(const std::vector<Section>& sections);

}  // namespace sagitta
