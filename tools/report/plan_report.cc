#include "tools/report/plan_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/results/plan_json.h"
#include "models/forward_model.h"
#include "problems/text.h"
#include "tools/report/charts.h"
#include "tools/report/report_html.h"
#include "tools/report/svg.h"

namespace sagitta {
namespace {

constexpr double kMillimetres = 1e3;
constexpr size_t kMostDrawn = 200;  // poses
constexpr double kPane = 150, kGap = 12, kTop = 18;

using Polyline = std::vector<Vector3<double>>;

// Where the joints are, base to flange, base frame, unloaded.
Polyline ArmOf(const ForwardModel& model, const Eigen::VectorXd& q) {
  const std::vector<double> theta = model.NominalValues();
  const std::vector<double> values = model.TransformValues(ShotInput(q), theta.data());
  ChainState<double> state;
  EvaluateChain(model.chain(), values.data(), &state);
  Polyline arm;
  for (const Pose<double>& frame : state.frames) {
    if (arm.empty() || (frame.translation - arm.back()).norm() > 1e-6) arm.push_back(frame.translation);
  }
  return arm;
}

// One scale for all pictures: what of the base frame is shown.
struct View {
  Vector3<double> low = Vector3<double>::Constant(1e300), high = -low;

  void Include(const Vector3<double>& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  double scale() const { return (kPane - 8) / std::max(1e-6, (high - low).maxCoeff()); }
  // Axis right and axis up, in a pane that begins at x.
  std::pair<double, double> At(const Vector3<double>& p, int right, int up, double x) const {
    return {x + 4 + scale() * (p[right] - low[right]), kTop + kPane - 4 - scale() * (p[up] - low[up])};
  }
};

std::string Pane(const View& view, const Polyline& arm, const Cell* cell, int right, int up, double x,
                 const std::string& title) {
  std::string body = svg::Text(x, 12, "start", title);
  for (const CellBox& box : cell != nullptr ? cell->keep_out : std::vector<CellBox>()) {
    View corners;
    for (int i = 0; i < 8; ++i) {
      const Vector3<double> sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      corners.Include(box.base_from_box * Vector3<double>(sign.cwiseProduct(box.half_size)));
    }
    const Vector3<double> low = corners.low.cwiseMax(view.low), high = corners.high.cwiseMin(view.high);
    if ((high - low).minCoeff() <= 0.0) continue;
    const auto [left, top] = view.At(Vector3<double>(low.x(), right == 1 ? low.y() : high.y(), high.z()), right, up, x);
    body += svg::Rectangle(left, top, view.scale() * (high[right] - low[right]), view.scale() * (high[up] - low[up]),
                           "taken", box.name);
  }
  std::vector<std::pair<double, double>> line, joints;
  for (const Vector3<double>& point : arm) line.push_back(view.At(point, right, up, x));
  joints.assign(line.begin(), line.end() - 1);
  return body + svg::Curve(line) + svg::Dots(joints, "dot") + svg::Dots({line.back()}, "model");
}

std::string Pictures(const Robot& robot, const Cell* cell, const Plan& plan) {
  const ForwardModel model(robot);
  std::vector<Polyline> arms;
  View view;
  for (const Configuration& configuration : plan.rows.configurations) {
    if (arms.size() == kMostDrawn) break;
    arms.push_back(ArmOf(model, configuration.q));
    for (const Vector3<double>& point : arms.back()) view.Include(point);
  }
  std::string html =
      "<h2>The arm in each pose</h2>\n<p>Base frame, unloaded; from the side (x to the right, z up) and from "
      "above (x to the right, y up); the flange in red. All in one scale: " +
      Fixed(kMillimetres * (view.high - view.low).maxCoeff(), 0) + " mm across.</p>\n";
  for (size_t k = 0; k < arms.size(); ++k) {
    const std::string& id = plan.rows.configurations[k].id;
    html += svg::Picture(
        2 * kPane + kGap, kPane + kTop, "arm in pose " + id,
        Pane(view, arms[k], cell, 0, 2, 0, id + ", side") + Pane(view, arms[k], cell, 0, 1, kPane + kGap, "above"));
  }
  if (arms.size() < plan.rows.configurations.size()) {
    html += "<p>" + std::to_string(plan.rows.configurations.size() - arms.size()) + " more are not drawn.</p>\n";
  }
  return html;
}

Section Overview(const Plan& plan) {
  Section section;
  section.title = "Plan of " + std::to_string(plan.rows.configurations.size()) + " poses";
  section.header = {"expected at the test poses", "mm"};
  section.rows = {{"RMS position error", Significant(kMillimetres * plan.position_rms, 3)},
                  {"worst point", Significant(kMillimetres * plan.position_max, 3)}};
  if (plan.HasModelError()) {
    section.rows.push_back({"RMS with model error", Significant(kMillimetres * plan.rms_with_model_error, 3)});
  }
  section.paragraphs = {CertificateInWords(plan)};
  section.paragraphs.insert(section.paragraphs.end(), plan.words.begin(), plan.words.end());
  return section;
}

Section Infeasible(const Plan& plan) {
  Section section{"Poses that cannot be measured", {}, {"reason", "poses tried"}, {}, ""};
  std::vector<std::pair<int, std::string>> reasons;
  for (const auto& [why, count] : plan.infeasible_because) reasons.emplace_back(-count, why);
  std::sort(reasons.begin(), reasons.end());
  for (const auto& [count, why] : reasons) section.rows.push_back({why, std::to_string(-count)});
  return section;
}

Section Accuracy(const Plan& plan) {
  Section section{"Accuracy over the number of poses", {}, {"poses", "RMS, mm"}, {}, ""};
  std::vector<double> poses, rms;
  for (const PosesAndAccuracy& point : plan.curve) {
    section.rows.push_back({std::to_string(point.poses), Significant(kMillimetres * point.position_rms, 3)});
    poses.push_back(point.poses);
    rms.push_back(kMillimetres * point.position_rms);
  }
  section.figure = ScatterChart("RMS position error, mm", "poses", poses, rms, {});
  return section;
}

Section Parameters(const Plan& plan) {
  Section section{"Parameters", {}, {"parameter", "95 % interval +-", "unit", ""}, {}, ""};
  for (const PlannedParameter& parameter : plan.parameters) {
    const QuantityTraits& traits = TraitsOf(parameter.quantity);
    section.rows.push_back({parameter.name, Significant(HalfWidth95(plan, parameter) / traits.si_per_unit, 3),
                            traits.unit, parameter.identifiable ? "" : "not determined"});
  }
  return section;
}

}  // namespace

std::string PlanReportToHtml(const Robot& robot, const Cell* cell, const Plan& plan, const Provenance& provenance) {
  std::vector<Section> sections = {Overview(plan)};
  if (!plan.infeasible_because.empty()) sections.push_back(Infeasible(plan));
  sections.push_back(Accuracy(plan));
  sections.push_back(Parameters(plan));
  return SectionsToPage(sections, Pictures(robot, cell, plan), provenance);
}

}  // namespace sagitta
