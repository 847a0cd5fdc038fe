#include "problems/whole_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "problems/experiment_checks.h"

namespace sagitta {
namespace {

constexpr double kUnitQuaternion = 1e-6;  // of its norm, off 1: what steps leave is 1e-16 each

class WholeProblem {
 public:
  WholeProblem(const CalibrationProblem& problem, const char* function) : problem_(problem), function_(function) {}

  void Check() const {
    CheckSizes();
    CheckBlocks();
    CheckCoordinates();
    CheckTie();
    CheckLatent();
    CheckRoots(problem_.resolved_noise, "resolved_noise", /*may_be_zero=*/true);
    CheckRoots(problem_.weight_roots, "weight_roots", /*may_be_zero=*/false);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw std::invalid_argument(std::string(function_) + ": " + what);
  }

  void CheckSizes() const {
    const Measurements& data = problem_.data();
    if (problem_.shot_inputs().size() != data.shots.size()) {
      Fail("the rows have " + std::to_string(data.shots.size()) + " shots, what acts is known of " +
           std::to_string(problem_.shot_inputs().size()) + ": RenewShots follows set_data");
    }
    if (problem_.marker_frames().size() != data.markers.size()) Fail("the rows have other markers than the problem");
  }

  // As they were made: the same names and sizes in the same order.
  void CheckBlocks() const {
    const Measurements& data = problem_.data();
    const ParameterSet expected(data.stations, data.markers, problem_.model().parameters(), data.OrientedMarkers());
    const ParameterSet& own = problem_.parameters;
    const auto is_alike = [](const ParameterBlock& a, const ParameterBlock& b) {
      return a.name == b.name && a.values.size() == b.values.size();
    };
    if (!std::equal(own.blocks().begin(), own.blocks().end(), expected.blocks().begin(), expected.blocks().end(),
                    is_alike)) {
      Fail("the parameters are those of another problem: begin with a copy of CalibrationProblem::parameters");
    }
    for (int i = 0; i < own.num_coordinates(); ++i) {
      const Coordinate &a = own.coordinates()[i], &b = expected.coordinates()[i];
      if (a.name == b.name && a.block == b.block && a.index_in_block == b.index_in_block) continue;
      Fail("coordinate " + std::to_string(i) + " is not that of '" + b.name + "'");
    }
    for (const ParameterBlock& block : own.blocks()) CheckValues(block);
  }

  void CheckValues(const ParameterBlock& block) const {
    double squares = 0.0;
    for (const double value : block.values) {
      if (!std::isfinite(value)) Fail("a start value of '" + block.name + "' is no number");
      squares += value * value;
    }
    if (IsRotation(block.kind) && !(std::abs(std::sqrt(squares) - 1.0) < kUnitQuaternion)) {
      Fail("the start value of '" + block.name + "' is no rotation");
    }
  }

  void CheckCoordinates() const {
    for (const Coordinate& coordinate : problem_.parameters.coordinates()) {
      const auto fail = [&](const char* what) { Fail("of '" + coordinate.name + "' " + what); };
      const bool is_spread = coordinate.prior_sigma >= 0.0 && std::isfinite(coordinate.prior_sigma);
      if (!is_spread) fail("the prior's standard deviation is no number, 0 or above");
      if (!std::isfinite(coordinate.prior_value)) fail("the prior's value is no number");
      if (!(coordinate.effect_prior >= 0.0)) fail("the effect's prior is no number, 0 or above");
      if (!(coordinate.lower < std::numeric_limits<double>::infinity())) fail("the lower bound is none");
      if (std::isnan(coordinate.hold_limit)) fail("the limit beyond which it is held is no number");
    }
  }

  void CheckTie() const {
    if (!problem_.parameters.spring_tie()) return;
    const SpringTie& tie = *problem_.parameters.spring_tie();
    const auto leads = [](int index, int count) { return index >= 0 && index < count; };
    const int markers = problem_.parameters.num_markers(), count = problem_.parameters.num_model_parameters();
    bool is_whole = leads(tie.lever_marker, markers) && leads(tie.anchor_marker, markers) &&
                    tie.errors.size() == tie.anchors.between.transforms.size();
    for (const int parameter : tie.geometry) is_whole &= leads(parameter, count);
    for (const int parameter : tie.errors) is_whole &= parameter == -1 || leads(parameter, count);
    if (!is_whole) Fail("the tie of markers to the spring is of another problem");
  }

  void CheckLatent() const {
    const LatentModel& latent = problem_.latent;
    const size_t shots = problem_.data().shots.size();
    if (latent.sigmas.size() != latent.size()) {
      Fail("latent: " + std::to_string(latent.size()) + " joints deviate, there are " +
           std::to_string(latent.sigmas.size()) + " standard deviations");
    }
    for (const int joint : latent.joints) {
      if (joint < 0 || joint >= problem_.robot().num_joints()) {
        Fail("latent: joint " + std::to_string(joint) + " is none of the robot (numbers begin at 0)");
      }
    }
    for (const double sigma : latent.sigmas) {
      if (!(sigma > 0.0 && std::isfinite(sigma))) Fail("latent: a standard deviation is no number above 0");
    }
    if (latent.visit_of_shot.size() != shots) {
      Fail("latent: a visit for each of " + std::to_string(shots) + " shots is expected, there are " +
           std::to_string(latent.visit_of_shot.size()));
    }
    for (const int visit : latent.visit_of_shot) {
      if (visit < 0 || visit >= latent.num_visits) Fail("latent: visit " + std::to_string(visit) + " does not exist");
    }
  }

  void CheckRoots(const NoiseRoots& roots, const std::string& name, bool may_be_zero) const {
    if (roots.empty()) return;
    const std::vector<Observation>& rows = problem_.data().observations;
    if (roots.size() != rows.size()) {
      Fail(name + ": one for each of " + std::to_string(rows.size()) + " observations is expected, there are " +
           std::to_string(roots.size()));
    }
    for (size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].excluded) continue;
      if ((may_be_zero && roots[i].isZero(0.0)) || IsRoot(roots[i])) continue;
      Fail(name + " of observation " + std::to_string(i) + " is no root of a covariance: it has no inverse" +
           (may_be_zero ? " and is not zero, which would state nothing" : ""));
    }
  }

  const CalibrationProblem& problem_;
  const char* const function_;
};

}  // namespace

void CheckIsWhole(const CalibrationProblem& problem, const char* function) {
  CheckExperiment(problem.experiment());
  WholeProblem(problem, function).Check();
}

}  // namespace sagitta
