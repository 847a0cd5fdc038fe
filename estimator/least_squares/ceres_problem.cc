#include "estimator/least_squares/ceres_problem.h"

#include <ceres/normal_prior.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "estimator/least_squares/constrained_blocks.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/least_squares/loss_function.h"
#include "estimator/least_squares/shot_cost.h"
#include "estimator/least_squares/spring_tie_cost.h"

namespace sagitta {
namespace {

// Model parameters that are estimated, in model order.
std::vector<int> ActiveModelParameters(const ParameterSet& parameters) {
  std::vector<int> active;
  for (int i = 0; i < parameters.num_model_parameters(); ++i) {
    if (parameters.coordinates()[parameters.model_parameter(i).first_coordinate].estimated()) active.push_back(i);
  }
  return active;
}

// Ceres would read beyond the memory of what does not belong together.
void CheckBelongTogether(const CalibrationProblem& problem, const ResidualSelection& selection,
                         const ParameterSet& parameters) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("AddToProblem: " + what); };
  const auto rows = static_cast<int>(problem.data().observations.size());
  for (const int row : selection.observations) {
    if (row < 0 || row >= rows) {
      fail("there is no observation " + std::to_string(row) + ", the problem has " + std::to_string(rows));
    }
  }
  if (selection.noise.size() != selection.observations.size()) {
    fail("a noise for each of " + std::to_string(selection.observations.size()) +
         " observations is expected, there are " + std::to_string(selection.noise.size()));
  }
  for (size_t k = 0; k < selection.noise.size(); ++k) {
    if (IsStated(selection.noise[k])) continue;
    fail("observation " + std::to_string(selection.observations[k]) + " has no noise");
  }
  if (!(selection.deviation_factor > 0.0)) fail("the factor of the joints' deviations is not above 0");
  const std::vector<ParameterBlock>& own = problem.parameters.blocks();
  const auto is_alike = [](const ParameterBlock& a, const ParameterBlock& b) {
    return a.name == b.name && a.values.size() == b.values.size();
  };
  if (!std::equal(own.begin(), own.end(), parameters.blocks().begin(), parameters.blocks().end(), is_alike)) {
    fail("the parameters are those of another problem: begin with a copy of CalibrationProblem::parameters");
  }
}

void AddShot(const CalibrationProblem& problem, const ResidualSelection& selection, size_t first, size_t last,
             const std::vector<int>& active, ceres::LossFunction* loss, ParameterSet* parameters,
             ceres::Problem* ceres_problem, LatentBlocks* latents) {
  const int shot_index = problem.data().observations[selection.observations[first]].shot;
  const Shot& shot = problem.data().shots[shot_index];
  std::vector<double*> blocks = {parameters->station_translation(shot.station).values.data(),
                                 parameters->station_rotation(shot.station).values.data()};
  std::vector<MarkerMeasurement> markers;
  for (size_t k = first; k < last; ++k) {
    const Observation& observation = problem.data().observations[selection.observations[k]];
    markers.push_back({problem.marker_frames()[observation.marker], observation.point_in_station,
                       selection.noise[k].inverse(), observation.marker, observation.kind,
                       observation.rotation().in_station});
    blocks.push_back(parameters->read_block(observation.marker, observation.kind).values.data());
  }
  for (const int i : active) blocks.push_back(parameters->model_parameter(i).values.data());
  std::vector<int> latent_joints;
  if (latents != nullptr && !problem.latent.empty()) {
    latent_joints = problem.latent.joints;
    blocks.push_back((*latents)[problem.latent.visit_of_shot[shot_index]].data());
  }
  ceres_problem->AddResidualBlock(ShotCost::Create(&problem.model(), problem.shot_inputs()[shot_index],
                                                   std::move(markers), parameters->ModelValues(), active, latent_joints)
                                      .release(),
                                  loss, blocks);
}

// Ours, and no prior that the problem's owner has put on a block.
class PriorOfSet : public ceres::CostFunction {
 public:
  PriorOfSet(const ceres::Matrix& weight, const ceres::Vector& center) : prior_(weight, center) {
    set_num_residuals(prior_.num_residuals());
    *mutable_parameter_block_sizes() = prior_.parameter_block_sizes();
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    return prior_.Evaluate(parameters, residuals, jacobians);
  }

 private:
  const ceres::NormalPrior prior_;
};

// What earlier calls have put into the problem.
struct EarlierCalls {
  std::set<const double*> with_prior;  // blocks
  std::set<const double*> deviations;  // blocks of visits, of this set's shots
};

EarlierCalls FindEarlierCalls(const ParameterSet& parameters, const ceres::Problem& ceres_problem) {
  EarlierCalls earlier;
  std::set<const double*> stations;
  for (int s = 0; s < parameters.num_stations(); ++s) stations.insert(parameters.station_translation(s).values.data());
  std::vector<ceres::ResidualBlockId> residuals;
  ceres_problem.GetResidualBlocks(&residuals);
  std::vector<double*> blocks;
  for (const ceres::ResidualBlockId id : residuals) {
    const ceres::CostFunction* const cost = ceres_problem.GetCostFunctionForResidualBlock(id);
    const auto* const shot = dynamic_cast<const ShotCost*>(cost);
    const bool deviates = shot != nullptr && shot->has_deviations();
    if (!deviates && dynamic_cast<const PriorOfSet*>(cost) == nullptr) continue;
    ceres_problem.GetParameterBlocksForResidualBlock(id, &blocks);
    if (!deviates) earlier.with_prior.insert(blocks[0]);
    if (deviates && stations.count(blocks[0]) > 0) earlier.deviations.insert(blocks.back());
  }
  return earlier;
}

// Makes one block per visit, or finds those of the calls before: a visit has one deviation, whatever is selected of it.
void PrepareDeviations(const LatentModel& model, const EarlierCalls& earlier, LatentBlocks* latents) {
  if (earlier.deviations.empty()) {
    if (latents != nullptr) latents->assign(model.num_visits, std::vector<double>(model.size(), 0.0));
    return;
  }
  std::set<const double*> own;
  if (latents != nullptr) {
    for (const std::vector<double>& block : *latents) own.insert(block.data());
  }
  const bool is_same = std::includes(own.begin(), own.end(), earlier.deviations.begin(), earlier.deviations.end());
  if (is_same && static_cast<int>(latents->size()) == model.num_visits) return;
  throw std::invalid_argument(
      "AddToProblem: these parameters are in the problem with deviations of the joints: give the same `latents` again");
}

// One residual (value - prior) / sigma per estimated coordinate that has one.
void AddPriors(const ParameterSet* parameters, const EarlierCalls& earlier, ceres::Problem* ceres_problem) {
  for (const Coordinate& coordinate : parameters->coordinates()) {
    if (!coordinate.has_prior() || !coordinate.estimated()) continue;
    const ParameterBlock& block = parameters->blocks()[coordinate.block];
    double* values = const_cast<double*>(block.values.data());
    if (!ceres_problem->HasParameterBlock(values) || earlier.with_prior.count(values) > 0) continue;
    ceres::Matrix weight = ceres::Matrix::Zero(1, block.tangent_size);
    weight(0, coordinate.index_in_block) = 1.0 / coordinate.prior_sigma;
    ceres::Vector center = ceres::Vector::Constant(block.tangent_size, coordinate.prior_value);
    ceres_problem->AddResidualBlock(new PriorOfSet(weight, center), nullptr, values);
  }
}

// delta_j / sigma_j per visit that is observed.
void AddLatentPriors(const Eigen::VectorXd& sigmas, const EarlierCalls& earlier, LatentBlocks* latents,
                     ceres::Problem* ceres_problem) {
  const ceres::Matrix weight = sigmas.cwiseInverse().asDiagonal();
  for (std::vector<double>& block : *latents) {
    if (!ceres_problem->HasParameterBlock(block.data()) || earlier.with_prior.count(block.data()) > 0) continue;
    ceres_problem->AddResidualBlock(new PriorOfSet(weight, ceres::Vector::Zero(sigmas.size())), nullptr, block.data());
  }
}

}  // namespace

ResidualSelection FittedResiduals(const CalibrationProblem& problem, double fallback) {
  ResidualSelection selection;
  selection.observations = problem.CalibrationObservations();
  selection.noise = FitRoots(problem, selection.observations, fallback);
  return selection;
}

ResidualSelection CalibrationResiduals(const CalibrationProblem& problem, double fallback) {
  const double found = problem.found_noise.sigma;
  ResidualSelection selection = FittedResiduals(problem, found > 0.0 ? found : fallback);
  selection.loss = problem.experiment().method.loss;
  if (!problem.weight_roots.empty()) return selection;
  selection.deviation_factor = problem.found_noise.factor;
  for (Matrix3<double>& root : selection.noise) root *= problem.found_noise.factor;
  return selection;
}

void AddToProblem(const CalibrationProblem& problem, const ResidualSelection& selection, ParameterSet* parameters,
                  ceres::Problem* ceres_problem, LatentBlocks* latents) {
  if (parameters == nullptr || ceres_problem == nullptr) {
    throw std::invalid_argument("AddToProblem: parameters or problem are null");
  }
  CheckBelongTogether(problem, selection, *parameters);
  const std::vector<int> active = ActiveModelParameters(*parameters);
  const EarlierCalls earlier = FindEarlierCalls(*parameters, *ceres_problem);
  PrepareDeviations(problem.latent, earlier, latents);
  const auto shot_of = [&](size_t k) { return problem.data().observations[selection.observations[k]].shot; };
  const bool is_whole_shot = selection.granularity == CostGranularity::kShot && selection.loss == LossKind::kNone;
  ceres::LossFunction* const loss = MakeLossFunction(selection.loss);
  for (size_t first = 0; first < selection.observations.size();) {
    size_t last = first + 1;
    if (is_whole_shot) {
      while (last < selection.observations.size() && shot_of(last) == shot_of(first)) ++last;
    }
    AddShot(problem, selection, first, last, active, loss, parameters, ceres_problem, latents);
    first = last;
  }
  AddPriors(parameters, earlier, ceres_problem);
  AddSpringTie(parameters, ceres_problem);
  if (latents != nullptr && !problem.latent.empty()) {
    AddLatentPriors(selection.deviation_factor * problem.latent.sigmas, earlier, latents, ceres_problem);
  }
  AddHeldBlocks(*parameters, ceres_problem);
  ConstrainBlocks(*parameters, ceres_problem);
}

}  // namespace sagitta
