#include "estimator/inspection/sampled_problem.h"

#include <algorithm>

#include "estimator/alignment/aligned_misfit.h"

namespace sagitta {
namespace {

int ConfigurationOf(const Measurements& data, int observation) {
  return data.shots[data.observations[observation].shot].configuration;
}

std::vector<bool> ChosenConfigurations(const CalibrationProblem& problem) {
  const Measurements& data = problem.data();
  std::vector<bool> is_fitted(data.configurations.size(), false), is_chosen = is_fitted;
  for (const int i : problem.CalibrationObservations()) is_fitted[ConfigurationOf(data, i)] = true;
  for (const int i : SampleOfRows(problem)) is_chosen[ConfigurationOf(data, i)] = true;
  std::vector<int> others;
  for (int c = 0; c < static_cast<int>(is_fitted.size()); ++c) {
    if (is_fitted[c] && !is_chosen[c]) others.push_back(c);
  }
  const auto chosen = std::count(is_chosen.begin(), is_chosen.end(), true);
  const auto room = std::min<long>(std::max<long>(0, kMostSampledConfigurations - chosen), others.size());
  for (long k = 0; k < room; ++k) is_chosen[others[k * others.size() / room]] = true;
  return is_chosen;
}

// What of the problem's rows is kept, with the indices between them made anew.
struct KeptRows {
  Measurements data;
  std::vector<int> shots, observations;  // of the whole problem
};

void KeepShot(const Measurements& all, int s, int configuration, KeptRows* kept) {
  Shot shot = all.shots[s];
  shot.configuration = configuration;
  shot.observations.clear();
  for (const int i : all.shots[s].observations) {
    Observation observation = all.observations[i];
    observation.shot = static_cast<int>(kept->data.shots.size());
    if (observation.file >= 0) {
      MeasurementFile& file = kept->data.files[observation.file];
      file.rows.Append(all.files[observation.file].rows[observation.row]);
      observation.row = static_cast<int>(file.rows.size()) - 1;
    }
    shot.observations.push_back(static_cast<int>(kept->data.observations.size()));
    kept->data.observations.push_back(observation);
    kept->observations.push_back(i);
  }
  kept->data.shots.push_back(shot);
  kept->shots.push_back(s);
}

KeptRows KeepRows(const CalibrationProblem& problem) {
  const Measurements& all = problem.data();
  const std::vector<bool> is_chosen = ChosenConfigurations(problem);
  KeptRows kept;
  kept.data.stations = all.stations;
  kept.data.markers = all.markers;
  for (const MeasurementFile& file : all.files) kept.data.files.push_back({file.path, file.sha256, file.header, {}});
  std::vector<int> now(all.configurations.size(), -1);
  for (size_t c = 0; c < all.configurations.size(); ++c) {
    if (!is_chosen[c]) continue;
    now[c] = static_cast<int>(kept.data.configurations.size());
    kept.data.configurations.push_back(all.configurations[c]);
  }
  for (int s = 0; s < static_cast<int>(all.shots.size()); ++s) {
    if (now[all.shots[s].configuration] >= 0) KeepShot(all, s, now[all.shots[s].configuration], &kept);
  }
  std::vector<int> place(all.observations.size(), -1);
  for (size_t k = 0; k < kept.observations.size(); ++k) place[kept.observations[k]] = static_cast<int>(k);
  for (Observation& observation : kept.data.observations) {
    if (observation.partner >= 0) observation.partner = place[observation.partner];
  }
  return kept;
}

}  // namespace

CalibrationProblem SampledProblem(const CalibrationProblem& problem) {
  if (static_cast<int>(problem.data().configurations.size()) <= kMostSampledConfigurations) return problem;
  KeptRows kept = KeepRows(problem);
  CalibrationProblem sampled = problem;
  sampled.set_data(std::move(kept.data));
  sampled.mutable_experiment()->validation = ValidationSpec();
  sampled.mutable_experiment()->validation.kind = ValidationSpec::Kind::kNone;
  sampled.latent = LatentModel();  // inspection assumes joints to be exact
  sampled.parameters.DropSpringTie();
  std::vector<ShotInput> inputs;  // time and temperature count from the origins of all rows
  for (const int s : kept.shots) inputs.push_back(problem.shot_inputs()[s]);
  sampled.set_shot_inputs(std::move(inputs));
  for (const int i : kept.observations) {
    if (!problem.resolved_noise.empty()) sampled.resolved_noise.push_back(problem.resolved_noise[i]);
    if (!problem.weight_roots.empty()) sampled.weight_roots.push_back(problem.weight_roots[i]);
  }
  return sampled;
}

}  // namespace sagitta
