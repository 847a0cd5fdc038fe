#include "tools/report/plan_report.h"

#include <algorithm>

#include "estimator/results/plan_json.h"
#include "models/constants.h"
#include "models/forward_model.h"
#include "problems/text.h"
#include "tools/report/charts.h"
#include "tools/report/report_html.h"
#include "tools/report/workspace.h"

namespace sagitta {
namespace {

// Of every pose its joint values.
void AddTable(const Robot& robot, const Plan& plan, Picture* picture) {
  picture->header = {"pose"};
  for (const Joint& joint : robot.chain.joints)
    picture->header.push_back(joint.name + (joint.type == JointType::kRevolute ? ", deg" : ", mm"));
  for (const Configuration& configuration : plan.rows.configurations) {
    std::vector<std::string> cells = {configuration.id};
    for (int j = 0; j < robot.chain.num_joints(); ++j) {
      const bool turns = robot.chain.joints[j].type == JointType::kRevolute;
      cells.push_back(Fixed(configuration.q[j] * (turns ? 1.0 / kDegree : kMillimetresPerMetre), 2));
    }
    picture->rows.push_back(cells);
  }
}

Section Poses(const Robot& robot, const Cell* cell, const Plan& plan) {
  const ForwardModel model(robot);
  const Workspace workspace(model, model.NominalValues(), plan.rows.configurations);
  Section section;
  section.title = "The arm in each pose";
  section.paragraphs = {"Base frame, unloaded, the flange in the second colour: " + Fixed(workspace.size(), 0) +
                        " mm across." + (cell != nullptr ? " Boxes: what the arm keeps out of." : "")};
  Picture picture;
  picture.title = "The arm in the selected pose, the others faint";
  AddTable(robot, plan, &picture);
  workspace.Draw(cell, &picture);
  section.pictures = {picture};
  return section;
}

Section Overview(const Plan& plan) {
  Section section;
  section.title = "Plan of " + Plural(static_cast<int>(plan.rows.configurations.size()), "pose");
  section.header = {"expected at the test poses", "mm"};
  section.rows = {{"RMS position error", Significant(kMillimetresPerMetre * plan.position_rms, 3)},
                  {"worst point", Significant(kMillimetresPerMetre * plan.position_max, 3)}};
  if (plan.HasModelError()) {
    section.rows.push_back({"RMS with model error", Significant(kMillimetresPerMetre * plan.rms_with_model_error, 3)});
  }
  section.paragraphs = {CertificateInWords(plan)};
  section.paragraphs.insert(section.paragraphs.end(), plan.words.begin(), plan.words.end());
  return section;
}

Section Infeasible(const Plan& plan) {
  Section section{"Poses that cannot be measured", {}, {"reason", "poses tried"}, {}};
  std::vector<std::pair<int, std::string>> reasons;
  for (const auto& [why, count] : plan.infeasible_because) reasons.emplace_back(-count, why);
  std::sort(reasons.begin(), reasons.end());
  for (const auto& [count, why] : reasons) section.rows.push_back({why, std::to_string(-count)});
  return section;
}

Section Accuracy(const Plan& plan) {
  Section section{"Accuracy over the number of poses", {CurveInWords(plan)}, {"poses", "RMS, mm"}, {}};
  std::vector<double> poses, rms;
  for (const PosesAndAccuracy& point : plan.curve) {
    section.rows.push_back({std::to_string(point.poses), Significant(kMillimetresPerMetre * point.position_rms, 3)});
    poses.push_back(point.poses);
    rms.push_back(kMillimetresPerMetre * point.position_rms);
  }
  if (poses.size() > 1)
    section.pictures = {CurvePicture("What more poses bring", "poses", poses, "RMS position error, mm", rms)};
  return section;
}

Section Parameters(const Plan& plan) {
  Section section{"Parameters", {}, {"parameter", "95 % interval +-", "unit", ""}, {}};
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
  sections.push_back(Poses(robot, cell, plan));
  sections.push_back(Parameters(plan));
  return SectionsToPage(sections, provenance);
}

}  // namespace sagitta
