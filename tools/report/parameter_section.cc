#include "tools/report/parameter_section.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "estimator/estimate/parameter_table.h"
#include "models/quantiles.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr const char* kByPrior = "prior";
constexpr double kLargeTurn = 0.1;  // rad: of smaller ones the components and a further turn differ by some per cent

// Half and more of the prior's standard deviation: the data say less than the robot file.
bool IsRuledByPrior(const ParameterEstimate& row, const Estimate& estimate) {
  const int i = estimate.parameters.FindCoordinate(row.name);
  return i >= 0 && row.free && 2.0 * row.sigma > estimate.parameters.coordinates()[i].effect_prior &&
         estimate.parameters.coordinates()[i].effect_prior > 0.0;
}

// "0.034", or "-0.012/+0.034" where the interval is not even about the value.
std::string Arms(const ParameterEstimate& row, double unit, int decimals) {
  const double down = (row.value - row.ci95.low) / unit, up = (row.ci95.high - row.value) / unit;
  if (IsEven(row)) return Fixed(0.5 * (up + down), decimals);
  return "-" + (row.open_low ? "open" : Fixed(down, decimals)) + "/+" + (row.open_high ? "open" : Fixed(up, decimals));
}

// SI: what the correction is added to. A geometric error's is the robot file's value of the length or angle that it is
// an error of; base and markers have none but where the alignment of the nominal robot puts them.
double NominalOf(const CalibrationProblem& problem, const ParameterEstimate& row) {
  if (CoordinateKindOf(row.name) != CoordinateKind::kGeometry) return row.nominal;
  const int transform = problem.robot().chain.FindError(NameWithinKind(row.name));
  return transform < 0 ? row.nominal : problem.robot().chain.transforms[transform].nominal;
}

// Half the 95 % intervals over the standard deviations: its median over what is estimated.
double CoverageFactor(const Estimate& estimate, double model_error) {
  std::vector<double> factors;
  for (const ParameterEstimate& row : estimate.table) {
    const double half = 0.5 * (row.ci95.high - row.ci95.low), sigma = model_error * row.sigma;
    if (row.free && sigma > 0.0 && std::isfinite(half) && IsEven(row)) factors.push_back(half / sigma);
  }
  return Median(factors);
}

// What the column ± is, in the words of ISO/IEC Guide 98-3 (GUM).
std::string UncertaintyInWords(const Estimate& estimate, double model_error) {
  const double factor = CoverageFactor(estimate, model_error);
  std::string words = "±: expanded uncertainty, coverage probability 95 %";
  if (factor > 0.0) words += ", coverage factor k = " + Significant(factor, 2);
  if (model_error > 1.0) words += "; model error is in it";
  return words + ".";
}

}  // namespace

ParameterEstimate AsShown(ParameterEstimate row) {
  if (row.conditional) row.ci95 = row.unconditional_ci95;
  return row;
}

std::string StateOf(const ParameterEstimate& row, const Estimate& estimate) {
  if (!row.identifiable) return StatedTooLarge(estimate) > 1.0 ? "held" : "not measured";
  if (!row.free) return "fixed";
  if (row.conditional) return "conditional";
  if (row.at_bound) return "at bound";
  if (IsRuledByPrior(row, estimate)) return kByPrior;
  return row.weak && StatedTooLarge(estimate) == 1.0 ? "weak" : "";
}

Section ParameterSection(const CalibrationProblem& problem, const Estimate& estimate, double model_error) {
  Section section;
  section.title = "Parameters";
  section.header = {"name", "nominal", "correction", "calibrated", "±", "unit", ""};
  bool any_at_bound = false, any_by_prior = false, any_turned = false;
  for (const ParameterEstimate& own : estimate.table) {
    const ParameterEstimate row = AsShown(own);
    const double correction = row.value - row.nominal, nominal = NominalOf(problem, row);
    if (!row.free && row.identifiable && correction == 0.0) continue;
    const QuantityTraits& traits = TraitsOf(row.quantity);
    const double half = 0.5 * (row.ci95.high - row.ci95.low) / traits.si_per_unit;
    const bool known = row.free && half > 0.0 && std::isfinite(half);
    const int decimals = DecimalsFor(known ? half : 0.0);
    const auto shown = [&](double value) { return Fixed(value / traits.si_per_unit, decimals); };
    section.rows.push_back({row.name, shown(nominal), shown(correction), shown(nominal + correction),
                            known ? Arms(row, traits.si_per_unit, decimals) : "-", ShownUnit(traits.unit),
                            StateOf(row, estimate)});
    any_turned |= known && row.quantity == Quantity::kRotationVector && std::abs(nominal + correction) > kLargeTurn;
    any_at_bound |= row.at_bound;
    any_by_prior |= section.rows.back().back() == kByPrior;
  }
  section.paragraphs = {UncertaintyInWords(estimate, model_error),
                        "nominal: of the robot file; of base poses and markers, which have none, where the nominal "
                        "robot fits best. calibrated: nominal + correction."};
  if (!estimate.identifiability.unidentifiable.empty()) {
    section.paragraphs.push_back(
        std::string(StatedTooLarge(estimate) > 1.0 ? "held: at the stated noise" : "not measured: held") +
        " where the data fit best; the value means nothing by itself. conditional: moves together with one that is "
        "held; its ± allows for what that one may be (`unconditional` in estimate.json; `ci95` there assumes it to be "
        "exact).");
  }
  if (any_turned) {
    section.paragraphs.push_back(
        "rx, ry, rz: components of a rotation vector; their ± is that of a further turn about the axes x, y, z of the "
        "frame in which the rotation is stated, not of the component, which a turn about another axis changes too.");
  }
  if (any_by_prior) {
    section.paragraphs.push_back(
        "prior: hardly measured; how large it may be is stated in the robot file (prior_sigma).");
  }
  if (any_at_bound) {
    section.paragraphs.push_back(
        "at bound: the interval meets a physical bound (a compliance is not below 0) and ends there; such a value "
        "is known as \"at most\". Its interval holds the truth more often than 95 %: what it would have beyond the "
        "bound is cut off.");
  }
  return section;
}

}  // namespace sagitta
