#include "estimator/planning/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/alignment/starting_values.h"
#include "estimator/least_squares/linearization.h"
#include "estimator/noise/weighting.h"
#include "estimator/planning/model_field.h"
#include "estimator/planning/pose_space.h"
#include "estimator/planning/scene_rows.h"
#include "estimator/report/planning_words.h"
#include "models/effects/catalogue.h"
#include "problems/excitation.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/robot_structure.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr int kMostPatterns = 8;   // ways to measure a configuration that are offered for every pose
constexpr int kRandomTests = 100;  // poses; their mean square is known to about a tenth
constexpr int kPlacing = 100;  // candidates in addition to the rows in the problem that base and markers are found with
constexpr int kTriesPerPose = 200;

bool NeedsApproach(const Robot& robot) {
  return std::any_of(robot.effects.begin(), robot.effects.end(), [&](const EffectSpec& effect) {
    return FindEffect(robot, effect.effect)->PressedByOf(effect) == PressedBy::kApproach;
  });
}

Robot WithEffects(const Robot& robot, const std::vector<EffectSpec>& added) {
  Robot extended = robot;
  for (const EffectSpec& effect : added) {
    const bool is_there = std::any_of(robot.effects.begin(), robot.effects.end(),
                                      [&](const EffectSpec& own) { return own.Path() == effect.Path(); });
    if (!is_there) extended.effects.push_back(effect);
  }
  return extended;
}

std::unique_ptr<CalibrationProblem> ProblemOf(const Robot& robot, const Measurements& rows,
                                              const Experiment& experiment, const std::vector<EffectSpec>& added) {
  Experiment whole = experiment;
  whole.validation = ValidationSpec();
  whole.validation.kind = ValidationSpec::Kind::kNone;
  auto problem =
      std::make_unique<CalibrationProblem>(MakeCalibrationProblem(WithEffects(robot, added), rows, std::move(whole)));
  for (const EffectSpec& effect : added) {
    for (const int i : problem->parameters.Match(effect.Path())) problem->parameters.coordinate(i).free = true;
  }
  return problem;
}

// Base and markers: registered to these readings where there are any, else as the experiment states them.
void Place(const std::vector<int>& read, CalibrationProblem* problem, std::vector<std::string>* words) {
  const Measurements& data = problem->data();
  std::vector<bool> is_read(data.markers.size(), false);
  for (const int k : read) is_read[data.observations[k].marker] = true;
  const ParameterSet stated = problem->parameters;
  if (!read.empty()) FindStartingValues(*problem, read, &problem->parameters);
  for (size_t m = 0; m < data.markers.size(); ++m) {
    if (is_read[m]) continue;
    const std::string& marker = data.markers[m];
    const auto spec = problem->experiment().markers.find(marker);
    if (spec == problem->experiment().markers.end() || !spec->second.point) {
      throw InputError({problem->experiment().file, 0, "markers"},
                       "nothing says where marker '" + marker + "' is: no row has a reading",
                       "state markers: {" + marker + ": {xyz_mm: …}} in the experiment file");
    }
    // Starting values of what no row sees are arbitrary.
    problem->parameters.SetMarkerPoint(static_cast<int>(m), stated.MarkerPoint(static_cast<int>(m)));
  }
  words->push_back(read.empty() ? PlacesAreStated() : PlacesFitReadings());
}

void CopyPlaces(const CalibrationProblem& from, CalibrationProblem* to) {
  for (size_t s = 0; s < to->data().stations.size(); ++s) {
    to->parameters.SetBaseInStation(static_cast<int>(s), from.parameters.BaseInStation(static_cast<int>(s)));
  }
  for (int m = 0; m < static_cast<int>(to->data().markers.size()); ++m) {
    to->parameters.SetMarkerPoint(m, from.parameters.MarkerPoint(m));
    if (to->parameters.is_oriented(m)) to->parameters.SetMarkerRotation(m, from.parameters.MarkerRotation(m));
  }
}

std::vector<int> All(size_t count) {
  std::vector<int> all(count);
  for (size_t i = 0; i < count; ++i) all[i] = static_cast<int>(i);
  return all;
}

// Draws poses, each with every way that the rows show.
class Drawing {
 public:
  // otherwise: m, of rows that state no standard deviation.
  Drawing(const Measurements& data, const std::vector<JointRange>& ranges, bool with_approach,
          std::optional<double> otherwise)
      : data_(data),
        ranges_(ranges),
        with_approach_(with_approach),
        patterns_(PatternsOf(data, kMostPatterns)),
        shots_(ShotsByConfiguration(data)) {
    for (const int pattern : patterns_.configurations) sights_.push_back(SightsOf(data, shots_[pattern]));
    for (const std::vector<int>& alike : patterns_.alike) alike_.emplace_back(data, alike, otherwise);
  }

  const ShotPatterns& patterns() const { return patterns_; }
  const std::vector<MeasuredAlike>& alike() const { return alike_; }

  // Until `count` poses can be measured in some way. feasible: null: all can. reasons: of those that cannot, null: not
  // counted.
  void Draw(int count, std::uint64_t seed, const std::string& prefix, const FeasiblePoses* feasible, SceneRows* rows,
            std::vector<int>* list, std::vector<int>* ways, std::map<std::string, int>* reasons) const {
    PoseSequence poses(ranges_, seed);
    std::vector<RandomTurns> turns;  // of each way
    for (size_t way = 0; way < alike_.size(); ++way) turns.emplace_back(alike_[way].size(), seed + way);
    const long most = feasible == nullptr ? count : std::max(20000L, static_cast<long>(kTriesPerPose) * count);
    int found = 0;
    for (long tried = 0; tried < most && found < count; ++tried) {
      CheckInterruption();
      const PoseSequence::Drawn pose = poses.Next();
      bool any = false;
      for (size_t way = 0; way < patterns_.configurations.size(); ++way) {
        const std::string why = feasible == nullptr ? "" : feasible->WhyNot(pose.q, sights_[way]);
        if (!why.empty()) {
          if (reasons != nullptr) ++(*reasons)[why];
          continue;
        }
        any = true;
        const int pattern = patterns_.configurations[way];
        const size_t first = rows->rows.shots.size();
        list->push_back(rows->Add(data_, pattern, shots_[pattern], pose.q, prefix + std::to_string(found + 1),
                                  with_approach_ ? pose.approach : std::vector<int>()));
        alike_[way].Complete(turns[way].Next(), first, &rows->rows);
        if (ways != nullptr) ways->push_back(static_cast<int>(way));
      }
      found += any ? 1 : 0;
    }
  }

  // One configuration of each way, to be moved.
  std::vector<int> Movable(SceneRows* rows) const {
    std::vector<int> movable;
    for (size_t way = 0; way < patterns_.configurations.size(); ++way) {
      const int pattern = patterns_.configurations[way];
      const Eigen::VectorXd q = data_.configurations[pattern].q;
      const size_t first = rows->rows.shots.size();
      movable.push_back(rows->Add(data_, pattern, shots_[pattern], q, "movable" + std::to_string(movable.size()),
                                  with_approach_ ? std::vector<int>(q.size(), 1) : std::vector<int>()));
      alike_[way].Complete(0, first, &rows->rows);
    }
    return movable;
  }

 private:
  const Measurements& data_;
  const std::vector<JointRange>& ranges_;
  const bool with_approach_;
  const ShotPatterns patterns_;
  const std::vector<std::vector<int>> shots_;
  std::vector<std::vector<Sight>> sights_;
  std::vector<MeasuredAlike> alike_;
};

// Rows count with what they state.
bool RowsStateTheNoise(const NoiseSpec& noise) {
  switch (noise.from) {
    case NoiseSpec::From::kRepeats:
    case NoiseSpec::From::kResiduals:
    case NoiseSpec::From::kInstrument:
      return false;
    case NoiseSpec::From::kDefault:
    case NoiseSpec::From::kSigma:
    case NoiseSpec::From::kRows:
    case NoiseSpec::From::kVarianceComponents:
      break;
  }
  return !noise.replaces_rows;
}

void SayWhatDiffers(const Drawing& drawing, const Experiment& experiment, std::vector<std::string>* words) {
  if (drawing.patterns().left_out > 0) words->push_back(PatternsLeftOut(drawing.patterns().left_out, kMostPatterns));
  if (!RowsStateTheNoise(experiment.noise)) return;
  std::optional<std::pair<double, double>> most;
  for (const MeasuredAlike& alike : drawing.alike()) {
    const auto own = alike.SigmasThatDiffer();
    if (own && (!most || own->second / own->first > most->second / most->first)) most = own;
  }
  if (most) words->push_back(SigmasOfAlikeRowsDiffer(most->first, most->second));
}

// An effect of the robot refuses rows without that column. lose: what a shot is without it.
bool AnyNeeds(const CalibrationProblem& problem, const std::vector<int>& configurations, const char* column,
              void (*lose)(ShotConditions*)) {
  const std::vector<EffectSpec>& effects = problem.robot().effects;
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(problem.data());
  const auto needs = [&](const ShotConditions& conditions) {
    return std::any_of(effects.begin(), effects.end(), [&](const EffectSpec& effect) {
      const EffectContext context{&problem.robot(), &effect, &conditions, &problem.data().markers, 0};
      return MissingColumn(*FindEffect(problem.robot(), effect.effect), context) == column;
    });
  };
  return std::any_of(configurations.begin(), configurations.end(), [&](int c) {
    return std::any_of(shots[c].begin(), shots[c].end(), [&](int s) {
      ShotConditions conditions = problem.shot_inputs()[s].conditions;
      lose(&conditions);
      return needs(conditions);
    });
  });
}

void SayWhatIsAssumed(const CalibrationProblem& problem, PlanScene* scene) {
  scene->goes_with_time =
      AnyNeeds(problem, scene->candidates, "time_s", [](ShotConditions* shot) { shot->has_time = false; });
  scene->goes_with_temperature = AnyNeeds(problem, scene->candidates, "temperature_degC",
                                          [](ShotConditions* shot) { shot->has_temperature = false; });
  if (scene->goes_with_time || scene->goes_with_temperature) {
    scene->words.push_back(ConditionsAreAssumed(scene->goes_with_time, scene->goes_with_temperature));
  }
  const Experiment& experiment = problem.experiment();
  if (experiment.repeatability.IsEstimated()) scene->words.push_back(RepeatabilityIsNotCounted());
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(problem.data());
  std::vector<int> rows;
  for (const int c : scene->candidates) rows.insert(rows.end(), observations[c].begin(), observations[c].end());
  if (WeighsOtherwise(problem, rows)) scene->words.push_back(BestWeightsAreAssumed(experiment.method.weights));
}

// The reasons, most frequent first.
std::vector<std::string> ReasonsInWords(const std::map<std::string, int>& reasons) {
  std::vector<std::pair<int, std::string>> sorted;
  for (const auto& [why, count] : reasons) sorted.emplace_back(-count, why);
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::string> words;
  for (const auto& [count, why] : sorted) words.push_back(why + " (" + std::to_string(-count) + ")");
  return words;
}

[[noreturn]] void FailInfeasible(const PlanScene& scene, const PlanRequest& request) {
  const bool is_listed = request.candidates != nullptr;
  const std::string file = request.cell != nullptr ? request.cell->file : "";
  throw InputError({file, 0, request.cell != nullptr ? "--cell" : "--candidates"},
                   std::string(is_listed ? "none of the listed candidates can be measured: "
                                         : "no pose that was drawn can be measured: ") +
                       Enumerate(ReasonsInWords(scene.infeasible), 4),
                   request.cell != nullptr
                       ? "widen what forbids most of them; frames and units of the cell are those of "
                         "the robot's base, mm and deg"
                       : "check the units of the list and the limits of the robot file");
}

// placed: whose stations and markers `feasible` knows; the list numbers its own.
std::vector<int> FeasibleOf(const Measurements& list, const Measurements& placed, const FeasiblePoses& feasible,
                            std::map<std::string, int>* reasons) {
  const std::vector<std::vector<int>> shots = ShotsByConfiguration(list);
  const auto index_in = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::vector<int> kept;
  for (size_t c = 0; c < list.configurations.size(); ++c) {
    std::vector<Sight> sights;
    for (const Sight& sight : SightsOf(list, shots[c])) {
      const int station = index_in(placed.stations, list.stations[sight.station]);
      const int marker = index_in(placed.markers, list.markers[sight.marker]);
      const bool is_known =
          station < static_cast<int>(placed.stations.size()) && marker < static_cast<int>(placed.markers.size());
      if (is_known) sights.push_back({station, marker});  // others are refused where the row is added
    }
    const std::string why = feasible.WhyNot(list.configurations[c].q, sights);
    if (why.empty()) {
      kept.push_back(static_cast<int>(c));
    } else {
      ++(*reasons)[why];
    }
  }
  return kept;
}

// Puts the readings that are expected into these configurations; drops those whose load folds the arm.
void ExpectReadings(PlanScene* scene) {
  CalibrationProblem& problem = *scene->problem;
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(problem.data());
  const auto expect = [&](const std::vector<int>& rows) {
    const Eigen::Matrix3Xd points = PredictPoints(problem, problem.parameters, rows);
    if (!points.allFinite()) return false;
    for (size_t k = 0; k < rows.size(); ++k)
      problem.mutable_data()->observations[rows[k]].Read(points.col(k), Vector3<double>::Zero());
    return true;
  };
  std::vector<int> together;
  for (const std::vector<int>* list : {&scene->candidates, &scene->tests}) {
    for (const int c : *list) together.insert(together.end(), observations[c].begin(), observations[c].end());
  }
  if (expect(together)) return;
  const auto holds = [&](int c) { return expect(observations[c]); };
  std::vector<int> kept, ways;
  for (size_t i = 0; i < scene->candidates.size(); ++i) {
    if (!holds(scene->candidates[i])) {
      ++scene->infeasible[HasNoEquilibrium()];
      continue;
    }
    kept.push_back(scene->candidates[i]);
    if (!scene->way_of.empty()) ways.push_back(scene->way_of[i]);
  }
  scene->candidates = kept;
  scene->way_of = ways;
  const long folded = std::count_if(scene->tests.begin(), scene->tests.end(), [&](int c) { return !holds(c); });
  if (folded > 0) {
    throw InputError({problem.experiment().file, 0, "loads"},
                     "at " + std::to_string(folded) + " test poses the load folds the arm: no equilibrium",
                     "check the load and the compliances, or leave these poses out");
  }
}

// The validation rows, without any all rows.
std::vector<int> TestsAmong(const Measurements& data) {
  std::vector<int> tests;
  const bool has_validation =
      std::any_of(data.configurations.begin(), data.configurations.end(),
                  [](const Configuration& configuration) { return configuration.is_validation; });
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (!has_validation || data.configurations[c].is_validation) tests.push_back(static_cast<int>(c));
  }
  return tests;
}

size_t PosesOf(const Measurements& data, const std::vector<int>& configurations) {
  std::set<std::vector<double>> poses;
  for (const int c : configurations) poses.insert({data.configurations[c].q.begin(), data.configurations[c].q.end()});
  return poses.size();
}

// Rows of a file to plan from, of which nothing is measured, may stand for a pose or two: fewer than there are joints
// show nothing of most of them.
void AddTests(const Measurements& data, const PlanRequest& request, const Drawing* drawing, SceneRows* rows,
              PlanScene* scene) {
  bool is_drawn = request.random_tests;
  if (request.tests != nullptr) {
    scene->tests = rows->AddTests(*request.tests);
  } else if (!is_drawn) {
    scene->tests = TestsAmong(data);
    const size_t poses = PosesOf(data, scene->tests);
    const auto joints = static_cast<size_t>(scene->placed->robot().num_joints());
    is_drawn = poses > 0 && poses < joints && drawing != nullptr;
    if (poses < joints) scene->words.push_back(FewTestPoses(poses, is_drawn));
  }
  scene->tests_are_drawn = is_drawn;
  if (is_drawn) {
    scene->tests.clear();
    drawing->Draw(kRandomTests, request.seed + 1, "T", scene->feasible.get(), rows, &scene->tests, nullptr, nullptr);
    const size_t drawn = scene->tests.size();
    if (drawn > 0 && drawn < kRandomTests) scene->words.push_back(FewTestPosesDrawn(drawn));
  }
  if (scene->tests.empty()) {
    throw InputError({"", 0, "--tests"}, "there is no test pose to be accurate at", "give --tests=FILE.csv");
  }
}

// Configurations that are fitted and have a reading.
std::vector<int> MeasuredOf(const Measurements& data, std::vector<std::string>* words) {
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(data);
  std::vector<int> measured;
  size_t lost = 0;
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (data.configurations[c].is_validation) continue;
    const auto is_read = [&](int i) { return data.observations[i].IsRead(); };
    const auto read = std::count_if(observations[c].begin(), observations[c].end(), is_read);
    if (read > 0) measured.push_back(static_cast<int>(c));
    lost += observations[c].size() - static_cast<size_t>(read);
  }
  if (measured.empty()) {
    throw InputError({"", 0, "--augment"}, "no row has a reading: nothing is measured to plan in addition to",
                     "leave --augment out, or give rows with x_mm, y_mm and z_mm");
  }
  if (lost > 0) words->push_back(RowsWithoutReading(lost));
  return measured;
}

// What the rows show and no row of a list: its configurations are not measured so.
std::vector<std::string> NotIn(const Measurements& list, const Measurements& data) {
  const auto ways_of = [](const Measurements& rows) {
    std::set<std::string> ways;
    for (const Observation& row : rows.observations) {
      const Shot& shot = rows.shots[row.shot];
      ways.insert({"marker " + rows.markers[row.marker], "station " + rows.stations[shot.station],
                   shot.load == kNoLoad ? "no load" : "load " + shot.load});
    }
    return ways;
  };
  const std::set<std::string> all = ways_of(data), listed = ways_of(list);
  std::vector<std::string> missing;
  std::set_difference(all.begin(), all.end(), listed.begin(), listed.end(), std::back_inserter(missing));
  return missing;
}

// Base and markers, found with the rows and some poses in addition, so that there are more equations than unknowns.
void FindPlaces(const Robot& robot, const Measurements& data, const Experiment& experiment, const PlanRequest& request,
                const Drawing* drawing, PlanScene* scene) {
  SceneRows rows(data, experiment.noise);
  std::vector<int> ignored, read;
  for (size_t k = 0; k < data.observations.size(); ++k) {
    if (data.observations[k].point_in_station.allFinite()) read.push_back(static_cast<int>(k));
  }
  if (request.tests != nullptr && rows.AddNamesOf(*request.tests)) {
    rows.AddTests(*request.tests);
    for (size_t k = data.observations.size(); k < rows.rows.observations.size(); ++k) {
      const Observation& row = rows.rows.observations[k];
      const bool is_new = row.marker >= static_cast<int>(data.markers.size()) ||
                          rows.rows.shots[row.shot].station >= static_cast<int>(data.stations.size());
      if (is_new && row.point_in_station.allFinite()) read.push_back(static_cast<int>(k));
    }
  }
  if (drawing != nullptr) {
    drawing->Draw(kPlacing, request.seed, "P", nullptr, &rows, &ignored, nullptr, nullptr);
  } else {
    rows.AddCandidates(*request.candidates, All(std::min<size_t>(kPlacing, request.candidates->configurations.size())));
  }
  scene->placed = ProblemOf(robot, rows.rows, experiment, request.discriminate);
  Place(read, scene->placed.get(), &scene->words);
  scene->feasible = std::make_unique<FeasiblePoses>(*scene->placed, request.cell);
}

}  // namespace

PlanScene MakePlanScene(const Robot& robot, const Measurements& data, const Experiment& experiment,
                        const PlanRequest& request) {
  CheckEffectSpecs(WithEffects(robot, request.discriminate));
  PlanScene scene;
  std::unique_ptr<Drawing> drawing;
  if (request.candidates == nullptr || request.random_tests) {
    scene.ranges = DrawingRanges(robot.chain, request.cell);
    drawing = std::make_unique<Drawing>(data, scene.ranges, NeedsApproach(WithEffects(robot, request.discriminate)),
                                        experiment.noise.sigma);
    if (request.candidates == nullptr) SayWhatDiffers(*drawing, experiment, &scene.words);
  }
  if (request.candidates != nullptr && request.candidates->configurations.empty()) {
    throw InputError({"", 0, "--candidates"}, "the list of candidates is empty");
  }
  FindPlaces(robot, data, experiment, request, request.candidates == nullptr ? drawing.get() : nullptr, &scene);
  SceneRows rows(data, experiment.noise);
  if (request.tests != nullptr) rows.AddNamesOf(*request.tests);
  if (request.augment) scene.measured = MeasuredOf(data, &scene.words);
  if (request.candidates != nullptr) {
    const std::vector<std::string> missing = NotIn(*request.candidates, data);
    if (!missing.empty()) scene.words.push_back(CandidatesLack(missing));
    scene.candidates = rows.AddCandidates(
        *request.candidates, FeasibleOf(*request.candidates, scene.placed->data(), *scene.feasible, &scene.infeasible));
    if (rows.without_sigma() > 0) scene.words.push_back(CandidatesStateNoSigma(rows.without_sigma()));
  } else {
    drawing->Draw(request.pool, request.seed, "P", scene.feasible.get(), &rows, &scene.candidates, &scene.way_of,
                  &scene.infeasible);
    scene.movable = drawing->Movable(&rows);
  }
  if (scene.candidates.empty()) FailInfeasible(scene, request);
  AddTests(data, request, drawing.get(), &rows, &scene);
  std::vector<EffectSpec> added = request.discriminate;
  if (request.field > 0.0) scene.field = FieldEffects(robot, request.discriminate);
  added.insert(added.end(), scene.field.begin(), scene.field.end());
  scene.problem = ProblemOf(robot, rows.rows, experiment, added);
  CopyPlaces(*scene.placed, scene.problem.get());
  SetHoldLimits(*scene.problem, &scene.problem->parameters);
  ExpectReadings(&scene);
  if (scene.candidates.empty()) {
    throw InputError({experiment.file, 0, "loads"}, "at no candidate does the arm hold its load: no equilibrium",
                     "check the load and the compliances");
  }
  SayWhatIsAssumed(*scene.problem, &scene);
  return scene;
}

}  // namespace sagitta
