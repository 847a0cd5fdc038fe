// The one problem type: what was given, what is unknown, and what rows weigh.
//
//   given    robot, measurements, experiment, and what follows from the three: shared by all problems made of each
//            other, so that a copy costs what is unknown and no more
//   unknown  ParameterSet (values; free, held or with a prior) and LatentModel
//   noise    a root per row where it was found and is not as stated
//
// Every method accepts it; how to solve is the method's (MethodSpec of the experiment, JointOptions), and what came out
// is an Estimate.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "models/forward_model.h"
#include "models/robot.h"
#include "problems/experiment.h"
#include "problems/latent_model.h"
#include "problems/measurements.h"
#include "problems/noise_model.h"
#include "problems/parameter_set.h"
#include "problems/reading_group.h"
#include "problems/shared_value.h"

namespace sagitta {

struct KnownPlaces;

// Copies of these are made in one place (calibration_problem.cc) and not in each file that knows a problem.
extern template Measurements* SharedValue<Measurements>::Own();
extern template Experiment* SharedValue<Experiment>::Own();
extern template std::vector<ShotInput>* SharedValue<std::vector<ShotInput>>::Own();

// The one effect that has a home of its own in the robot (Robot::gravity_compensator).
bool IsGravityCompensator(const EffectSpec& spec);
bool IsWeight(const Robot& robot, const EffectSpec& spec);  // EffectDefinition::is_weight
// Whether a coordinate of this name is a parameter of the effect, or of the compensator.
bool IsParameterOf(const EffectSpec& spec, const std::string& name);

// Robot, measurements and experiment with what is unknown. Always whole: MakeCalibrationProblem and MakeKnownProblem
// are the only sources, all others are copies.
class CalibrationProblem {
 public:
  CalibrationProblem(const CalibrationProblem&);
  CalibrationProblem(CalibrationProblem&&) noexcept;
  CalibrationProblem& operator=(const CalibrationProblem&);
  CalibrationProblem& operator=(CalibrationProblem&&) noexcept;
  ~CalibrationProblem();

  const Robot& robot() const { return model_->robot(); }  // with the tilt slots that effects need
  const ForwardModel& model() const { return *model_; }   // of `robot`
  const Measurements& data() const { return *data_; }
  const Experiment& experiment() const { return *experiment_; }
  // Chain frame of each marker of `data`.
  const std::vector<int>& marker_frames() const { return *marker_frames_; }
  std::vector<int> MarkersOnFlange() const;  // indices
  // Joint values, conditions and wrenches of each shot of `data`, prepared for the model.
  const std::vector<ShotInput>& shot_inputs() const { return *shot_inputs_; }

  // Given otherwise, for this problem alone. Readings, exclusions and the split may change at will; where joint values
  // or conditions do, RenewJoints or RenewShots follows. The pointers are for changes before the problem is copied: who
  // copies it shares what they lead to, and a change by an old pointer is one of all copies since. After a copy (a call
  // of Calibrate is one) ask for the pointer again.
  Measurements* mutable_data() {
    fitted_.reset();
    return data_.Own();
  }
  // Other rows. What was found of each of the old ones (resolved_noise, weight_roots) is not theirs: they weigh as they
  // state, until it is set anew. The joints' deviations are those of their own visits, as large as before.
  void set_data(Measurements data);
  Experiment* mutable_experiment() { return experiment_.Own(); }
  std::vector<ShotInput>* mutable_shot_inputs() { return shot_inputs_.Own(); }
  void set_shot_inputs(std::vector<ShotInput> inputs);
  void set_marker_frame(int marker, int frame);
  // Joint values of the shots as the configurations have them now; everything else of the shots stays.
  void RenewJoints();
  // All that acts in the shots, as data and experiment say now, and their visits. Where there are more or fewer rows
  // than before, what was found of each row goes, as with set_data.
  void RenewShots();

  ParameterSet parameters;                    // start values; free and fixed as the experiment says
  LatentModel latent;                         // joint deviations per visit; empty where repeatability is 0
  std::vector<std::string> redundant_errors;  // default free set: what stays nominal

  // Noise that is found, not stated (from repeats, or by the estimator): one root
  // per observation, in place of what is stated. Empty: as stated.
  NoiseRoots resolved_noise;
  // What an estimate of this problem says of the noise as a whole. Fits do not use it: they find it again.
  struct FoundNoise {
    double sigma = 0.0;   // m (of rotations rad), of every coordinate where nothing states a noise; 0: not found
    double factor = 1.0;  // by which the noise is larger than SqrtCovariance
  };
  FoundNoise found_noise;
  // By which the noise is another than stated, of whatever row, as far as that was found; in resolved_noise too.
  double stated_noise_factor = 1.0;
  NoiseOrigin noise_origin = NoiseOrigin::kStated;
  // rad, of every axis: what rotations that state none were found to scatter by, where no repeats give it; in
  // resolved_noise too. 0: none was looked for.
  double rotation_noise = 0.0;
  std::vector<ScaledGroup> scaled_groups;  // in addition, of these
  // Roots the fit weighs with in place of the noise's (estimator/noise/weighting.h): the
  // noise then says what the estimate is worth, not how it is made. Empty: the noise's.
  NoiseRoots weight_roots;
  std::optional<RepeatScatter> repeat_scatter;  // where the noise is from repeats

  // Root of the noise covariance of an observation, m or rad (problems/noise_model.h);
  // zero where nothing states one: then all rows share one sigma that is estimated.
  Matrix3<double> SqrtCovariance(int observation) const;
  bool sigma_is_stated() const;

  // The same problem with more effects in the robot; their parameters are free
  // and start at the specs' values (none: neutral), all others keep values and
  // flags. A `gravity_compensator` (values L, a_x, a_y, s0, Kc) goes to its home;
  // its L is held: the scale gauge.
  CalibrationProblem WithEffects(const std::vector<EffectSpec>& specs) const;

  // Paths of the files that it was read from: experiment, robot and rows, as far as it was.
  std::vector<std::string> InputPaths() const;
  // The robot with these values, and with the priors of its effects that these parameters have.
  Robot RobotWith(const ParameterSet& own) const;
  // degC; absent: no effect of the robot goes with a temperature that is measured.
  std::optional<double> ReferenceTemperature() const;

  // Observations that are fitted, and those of held-out configurations, by index; none that is excluded.
  std::vector<int> CalibrationObservations() const;
  std::vector<int> ValidationObservations() const;

 private:
  void ForgetRows();  // resolved_noise and weight_roots

  friend CalibrationProblem MakeCalibrationProblem(Robot, Measurements, Experiment);
  friend CalibrationProblem MakeKnownProblem(const Robot&, Measurements, Experiment, const KnownPlaces&);

  // All unknowns at their nominal values; throws InputError.
  CalibrationProblem(ForwardModel model, SharedValue<Measurements> data, SharedValue<Experiment> experiment);

  SharedValue<ForwardModel> model_;
  SharedValue<Measurements> data_;
  SharedValue<Experiment> experiment_;
  SharedValue<std::vector<int>> marker_frames_;
  SharedValue<std::vector<ShotInput>> shot_inputs_;
  std::shared_ptr<const std::vector<int>> fitted_;  // found when the problem was made; null: the data may have changed
};

// Reads nothing: checks that robot and data fit together (structure_checks.h), puts them together with the experiment,
// marks the split and checks what only all three show (unknown names, fewer equations than unknowns, a station or
// marker that no fitted row has, a load without a point or a force). Throws InputError.
CalibrationProblem MakeCalibrationProblem(Robot robot, Measurements data, Experiment experiment);

// Where stations and markers are, from an estimate or a truth.
struct KnownPlaces {
  std::map<std::string, Pose<double>> base_in_station;  // of every station, by name
  std::map<std::string, MarkerSpec> markers;            // point (m) and rotation of each that is known
};

// The problem of prediction and simulation, where nothing is to be found: stations and markers where they are known to
// be (others at the origin), the robot as it is. Throws InputError, also where a place is no number or its rotation
// none.
CalibrationProblem MakeKnownProblem(const Robot& robot, Measurements data, Experiment experiment,
                                    const KnownPlaces& places);

}  // namespace sagitta
