// Writes the numbers of a plan's approximate design as JSON: the candidates' rows, what is known, the criterion, and
// the optimum with its bound as the library finds them.
//
// usage: sagitta_export_design CRITERION POSES CANDIDATES
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "estimator/planning/numbers.h"
#include "problems/io/experiment_inputs.h"
#include "tests/support/paths.h"

namespace {

nlohmann::json ToJson(const Eigen::MatrixXd& matrix) {
  nlohmann::json rows = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(std::vector<double>(matrix.cols()));
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) rows.back()[j] = matrix(i, j);
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::string experiment = sagitta::test::SourceFolder() + "/problems/published/kr270/experiment.yaml";
  const sagitta::ExperimentInputs inputs = sagitta::ReadExperimentInputs({experiment});
  sagitta::PlanRequest request;
  request.criterion = sagitta::CriterionNamed(argv[1]);
  request.poses = std::atoi(argv[2]);
  request.pool = std::atoi(argv[3]);
  const sagitta::PlanScene scene = sagitta::MakePlanScene(inputs.robot, inputs.data, inputs.experiment, request);
  const sagitta::PlanNumbers numbers = sagitta::MakePlanNumbers(scene);
  const sagitta::Criterion criterion = sagitta::CriterionFor(*scene.problem, numbers, request);
  const sagitta::ApproximateDesign design =
      sagitta::SolveApproximate(numbers.set, numbers.known, criterion, request.poses, 1e-5, 200000);
  const nlohmann::json json = {{"criterion", argv[1]},
                               {"poses", request.poses},
                               {"rows", ToJson(numbers.set.rows)},
                               {"first", numbers.set.first},
                               {"known", ToJson(numbers.known)},
                               {"weight", ToJson(criterion.weight)},
                               {"interest", criterion.interest},
                               {"cost", design.cost},
                               {"bound", design.bound},
                               {"iterations", design.iterations}};
  std::cout << json.dump() << "\n";
  return 0;
}
