#include "tools/report/parameter_pictures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "estimator/statistics/distributions.h"
#include "problems/text.h"
#include "tools/report/parameter_section.h"
#include "tools/report/summary.h"

namespace sagitta {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostCorrelated = 60;
constexpr size_t kPairsShown = 20;

// How many times better known than weak, by the interval that is shown: its standard uncertainty is the longer arm over
// the quantile (u = U / k), for a bound may cut the other arm off. A quantity without a limit is weak where that is
// half its value. NaN: the interval does not end.
double TimesBetterThanWeak(const ParameterEstimate& shown) {
  const double limit = TraitsOf(shown.quantity).weak_limit;
  const double arm = std::max(shown.value - shown.ci95.low, shown.ci95.high - shown.value);
  if (!(arm > 0.0) || !std::isfinite(arm) || shown.open_low || shown.open_high) return NAN;
  return (limit > 0.0 ? limit : 0.5 * std::abs(shown.value)) * StudentQuantile(0.975, shown.dof) / arm;
}

}  // namespace

std::vector<Picture> KnownParameters(const Estimate& estimate) {
  Picture picture;
  picture.kind = "parameters";
  picture.title =
      "Corrections with their 95 % intervals, as under \"Parameters\" (hollow: weak, at a bound or conditional), and "
      "how "
      "many times better they are known than what counts as weak: 1 mm, 1 mrad or half the value; below 1 in the "
      "second "
      "colour";
  picture.header = {"parameter", "correction", "95 % from", "to", "unit", "times better known", ""};
  PictureMenu menu{"group", "of", {}};
  Json& data = picture.data["rows"];
  for (const ParameterEstimate& own : estimate.table) {
    const ParameterEstimate row = AsShown(own);
    if (!row.free || !row.identifiable || !(row.sigma > 0.0)) continue;
    const QuantityTraits& traits = TraitsOf(row.quantity);
    const std::string unit = ShownUnit(traits.unit), group = row.name.substr(0, row.name.find('/')) + ", " + unit;
    const double scale = 1.0 / traits.si_per_unit, known = TimesBetterThanWeak(row);
    const double value = scale * (row.value - row.nominal), low = scale * (row.ci95.low - row.nominal),
                 high = scale * (row.ci95.high - row.nominal);
    const std::string state = StateOf(row, estimate), high_shown = row.open_high ? "open" : Significant(high, 4);
    const std::string low_shown = row.open_low ? "open" : Significant(low, 4);
    const std::pair<std::string, std::string> option{group, group};
    if (std::find(menu.options.begin(), menu.options.end(), option) == menu.options.end())
      menu.options.push_back(option);
    picture.settings["units"][group] = unit;
    data["name"].push_back(row.name);
    data["group"].push_back(group);
    data["value"].push_back(Rounded(value, 6));
    data["low"].push_back(Rounded(low, 6));
    data["high"].push_back(Rounded(high, 6));
    data["known"].push_back(Rounded(known, 3));
    data["state"].push_back(state);
    data["words"].push_back(row.name + ": " + Significant(value, 4) + " " + unit + ", 95 % from " + low_shown + " to " +
                            high_shown + (state.empty() ? "" : "; " + state));
    picture.rows.push_back({row.name, Significant(value, 4), low_shown, high_shown, unit,
                            std::isfinite(known) ? Significant(known, 3) : "-", state});
  }
  if (picture.rows.empty()) return {};
  picture.menus = {menu};
  return {picture};
}

std::vector<Picture> Correlations(const Estimate& estimate) {
  const Eigen::Index n = estimate.covariance.rows();
  if (n < 2 || static_cast<Eigen::Index>(estimate.estimated.size()) != n) return {};
  const Eigen::VectorXd deviation = estimate.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const auto correlation = [&](Eigen::Index a, Eigen::Index b) {
    const double product = deviation[a] * deviation[b];
    return product > 0.0 ? std::clamp(estimate.covariance(a, b) / product, -1.0, 1.0) : 0.0;
  };
  const auto name = [&](Eigen::Index i) { return estimate.parameters.coordinates()[estimate.estimated[i]].name; };
  std::vector<double> largest(n, 0.0);
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs;
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      pairs.emplace_back(a, b);
      const double size = std::abs(correlation(a, b));
      largest[a] = std::max(largest[a], size);
      largest[b] = std::max(largest[b], size);
    }
  }
  std::vector<Eigen::Index> shown(n);
  std::iota(shown.begin(), shown.end(), 0);
  std::stable_sort(shown.begin(), shown.end(), [&](Eigen::Index a, Eigen::Index b) { return largest[a] > largest[b]; });
  shown.resize(std::min<size_t>(shown.size(), kMostCorrelated));
  std::sort(shown.begin(), shown.end());

  Picture picture;
  picture.kind = "correlation";
  picture.title = "Which parameters the data determine only together: correlation, framed above 0.9";
  if (shown.size() < static_cast<size_t>(n))
    picture.title += "; the " + std::to_string(kMostCorrelated) + " most correlated of " + std::to_string(n);
  Json& data = picture.data["pairs"];
  for (size_t i = 0; i < shown.size(); ++i) {
    for (size_t k = 0; k <= i; ++k) {
      data["a"].push_back(name(shown[i]));
      data["b"].push_back(name(shown[k]));
      data["r"].push_back(Rounded(i == k ? 1.0 : correlation(shown[i], shown[k]), 3));
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [&](const auto& a, const auto& b) {
    return std::abs(correlation(a.first, a.second)) > std::abs(correlation(b.first, b.second));
  });
  picture.header = {"the most correlated", "with", "correlation"};
  for (size_t i = 0; i < std::min(kPairsShown, pairs.size()); ++i) {
    const auto& [a, b] = pairs[i];
    picture.rows.push_back({name(a), name(b), Fixed(correlation(a, b), 3)});
  }
  return {picture};
}

}  // namespace sagitta
