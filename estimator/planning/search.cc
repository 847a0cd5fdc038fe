#include "estimator/planning/search.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "models/constants.h"
#include "problems/input_error.h"
#include "problems/interruption.h"
#include "problems/text.h"

namespace sagitta {
namespace {

// Of the certificate, relative to the cost: of the plan that is handed out, and on the way there.
constexpr double kTolerance = 0.01, kOnTheWay = 0.03;
constexpr double kNextToBest = 0.95;  // efficiency from which on a plan is not chosen again from what its poses became
constexpr double kWorthATurn = 1e-3;  // of the cost
constexpr int kMostTurns = 5;         // a guard: kNextToBest and kWorthATurn end them
constexpr int kShortList = 2000;      // candidates of the curve
constexpr int kMostStarts = 40;       // of searches for candidates other than those drawn

using CostOfRows = std::function<double(const Eigen::MatrixXd&)>;

// Coordinate search in the feasible set (Hooke and Jeeves, J. ACM 8, 1961): one joint at a time by a share of its
// range, ever smaller ones, and the sides of approach.
class LocalSearch {
 public:
  LocalSearch(const std::vector<JointRange>& ranges, PoseRows* rows) : ranges_(ranges), rows_(rows) {}

  // Moves the pose while the cost falls; returns the cost.
  // Shares of the ranges, each a third of the one before: the last moves a joint of 360 deg by 1.8.
  double Improve(const CostOfRows& cost, double now, PlannedPose* pose) const {
    for (const double share : {0.15, 0.05, 0.015, 0.005}) {
      for (int sweep = 0; sweep < 4; ++sweep) {
        bool better = false;
        for (int j = 0; j < static_cast<int>(ranges_.size()); ++j) better |= ImproveJoint(cost, j, share, &now, pose);
        if (!better) break;
      }
    }
    return now;
  }

 private:
  bool ImproveJoint(const CostOfRows& cost, int j, double share, double* now, PlannedPose* pose) const {
    const JointRange& range = ranges_[j];
    bool better = false;
    if (!pose->approach.empty()) {
      PlannedPose turned = *pose;
      turned.approach[j] = -turned.approach[j];
      better |= Take(cost, turned, now, pose);
    }
    if (!range.levels.empty()) {
      for (const double level : range.levels) {
        PlannedPose there = *pose;
        there.q[j] = level;
        if (level != pose->q[j]) better |= Take(cost, there, now, pose);
      }
      return better;
    }
    for (const double sign : {1.0, -1.0}) {
      bool moved = false;
      for (double step = sign * share * (*range.max - *range.min);; step *= 1.5) {  // as long as it gets better
        PlannedPose there = *pose;
        there.q[j] = std::clamp(pose->q[j] + step, *range.min, *range.max);
        if (there.q[j] == pose->q[j] || !Take(cost, there, now, pose)) break;
        moved = true;
      }
      better |= moved;
      if (moved) break;
    }
    return better;
  }

  bool Take(const CostOfRows& cost, const PlannedPose& pose, double* now, PlannedPose* best) const {
    if (!rows_->IsFeasible(pose)) return false;
    const Eigen::MatrixXd rows = rows_->At(pose);
    const double trial = rows.size() > 0 ? cost(rows) : kInfinity;
    if (!(trial < *now - 1e-9 * std::abs(*now))) return false;
    *now = trial;
    *best = pose;
    best->candidate = -1;
    return true;
  }

  const std::vector<JointRange>& ranges_;
  PoseRows* rows_;
};

}  // namespace

PlanSearch::PlanSearch(PlanScene* scene, PlanNumbers* numbers, const Criterion& criterion, const PlanRequest& request)
    : scene_(scene), numbers_(numbers), criterion_(criterion), request_(request), rows_(scene, *numbers) {
  const Measurements& data = scene->problem->data();
  for (size_t i = 0; i < scene->candidates.size(); ++i) {
    const int c = scene->candidates[i];
    const bool is_listed = scene->way_of.empty();
    candidates_.push_back({c, is_listed ? -1 : scene->way_of[i], data.configurations[c].q, {}, is_listed ? -1 : c});
  }
  if (scene->way_of.empty()) return;
  std::vector<int> candidate_of(data.configurations.size(), -1);
  for (size_t i = 0; i < scene->candidates.size(); ++i) candidate_of[scene->candidates[i]] = static_cast<int>(i);
  for (const Shot& shot : data.shots) {  // drawn with a side of approach where it matters
    const int i = candidate_of[shot.configuration];
    if (i >= 0) candidates_[i].approach = shot.approach;
  }
}

double PlanSearch::Rms(const Eigen::MatrixXd& covariance) const {
  return std::sqrt(criterion_.weight.cwiseProduct(numbers_->OfPlainFit(covariance)).sum());
}

void PlanSearch::CheckSupply(int poses) const {
  const int least = numbers_->LeastPoses();
  if (poses < least) {
    throw InputError({"", 0, "--poses"},
                     "fewer readings than unknowns: " + std::to_string(poses) + " poses cannot determine " +
                         std::to_string(numbers_->unknowns()) + " parameters",
                     "at least " + std::to_string(least) +
                         " poses; or free less (estimate: {geometry: [NAME, …]} in the experiment file), or give "
                         "--augment where the rows of the experiment are measured already");
  }
  if (request_.candidates == nullptr || poses <= numbers_->set.size()) return;
  throw InputError({"", 0, "--poses"},
                   std::to_string(poses) + " poses are asked for and there are " +
                       std::to_string(numbers_->set.size()) + " feasible candidates",
                   "ask for fewer, or list more");
}

ApproximateDesign PlanSearch::Approximate(int poses, double tolerance) {
  Eigen::VectorXd start;
  if (weights_.size() > 0) {  // those of another number of poses, and a little for what joined since
    start = Eigen::VectorXd::Zero(numbers_->set.size());
    start.head(weights_.size()) = weights_;
    const int joined = numbers_->set.size() - static_cast<int>(weights_.size());
    if (joined > 0) start.tail(joined).setConstant(0.3 / joined);
    start /= start.sum();
  }
  ApproximateDesign design = SolveApproximate(numbers_->set, numbers_->known, criterion_, poses, tolerance, 3000,
                                              start.size() > 0 ? &start : nullptr);
  weights_ = design.weights;
  return design;
}

void PlanSearch::FindGivenMeasured(int poses) {
  const LocalSearch search(scene_->ranges, &rows_);
  for (int round = 0; round < 2; ++round) {
    const ApproximateDesign design = Approximate(poses, kOnTheWay);
    const CostOfRows loss = [&](const Eigen::MatrixXd& rows) {
      return -(rows * design.slope).cwiseProduct(rows).sum();
    };
    std::vector<Eigen::MatrixXd> joining;
    for (const int i : Foremost(design.gain, kMostStarts)) {
      PlannedPose pose = candidates_[i];
      const double now = loss(numbers_->set.of(i));
      if (!(search.Improve(loss, now, &pose) < now)) continue;
      joining.push_back(rows_.At(pose));
      candidates_.push_back(pose);
    }
    if (joining.empty()) return;
    numbers_->set.Append(joining);
    found_given_measured_ += static_cast<int>(joining.size());
  }
}

ExactDesign PlanSearch::Exact(int poses, const ApproximateDesign& approximate, int starts, int rounds) const {
  ExactOptions options;
  options.repeats = request_.candidates == nullptr;
  options.seed = request_.seed;
  options.starts = starts;
  options.rounds = rounds;
  return SolveExact(numbers_->set, numbers_->known, criterion_, poses, approximate, options);
}

void PlanSearch::MovePoses(FoundPlan* found) {
  constexpr int kRounds = 3;
  constexpr double kWorth = 1e-4;  // of the cost: a round that saves less is the last
  const LocalSearch search(scene_->ranges, &rows_);
  std::vector<Eigen::MatrixXd> rows;
  std::vector<bool> moved(found->picks.size(), false);
  for (const int pick : found->picks) rows.push_back(numbers_->set.of(pick));
  for (int round = 0; round < kRounds; ++round) {
    const double before = found->cost;
    for (size_t k = 0; k < rows.size(); ++k) {
      CheckInterruption();
      const Eigen::MatrixXd without = Updated(found->covariance, rows[k], -1.0);
      const CostGiven given(criterion_, without);
      PlannedPose pose = found->poses[k];
      const double now = given.With(rows[k]);
      const double cost = search.Improve([&](const Eigen::MatrixXd& own) { return given.With(own); }, now, &pose);
      if (!(cost < now)) continue;
      found->poses[k] = pose;
      moved[k] = true;
      rows[k] = rows_.At(pose);
      found->covariance = Updated(without, rows[k], 1.0);
      found->cost = cost;
    }
    if (before - found->cost < kWorth * std::abs(before)) break;
  }
  // What moved joins the candidates, so that the certificate speaks of it.
  std::vector<Eigen::MatrixXd> joining;
  for (size_t k = 0; k < rows.size(); ++k) {
    if (!moved[k]) continue;
    found->picks[k] = numbers_->set.size() + static_cast<int>(joining.size());
    candidates_.push_back(found->poses[k]);
    joining.push_back(rows[k]);
  }
  numbers_->set.Append(joining);
  found_given_measured_ += static_cast<int>(joining.size());
  found->covariance = CovarianceOf(numbers_->set, numbers_->known, found->picks);
  found->cost = criterion_.Cost(found->covariance);
}

FoundPlan PlanSearch::ChosenOf(int poses, const ApproximateDesign& approximate) const {
  const ExactDesign exact = Exact(poses, approximate, request_.starts, 20);
  FoundPlan found;
  found.approximate = approximate;
  found.picks = exact.picks;
  found.covariance = exact.covariance;
  found.cost = exact.cost;
  for (const int pick : found.picks) found.poses.push_back(candidates_[pick]);
  return found;
}

bool PlanSearch::IsNextToBest(const FoundPlan& found) const {
  return criterion_.HasCertificate() && criterion_.Efficiency(found.cost, found.approximate.bound) > kNextToBest;
}

FoundPlan PlanSearch::At(int poses) {
  CheckSupply(poses);
  if (request_.progress) request_.progress("best " + std::to_string(poses) + " poses");
  if (may_move() && criterion_.HasCertificate() && found_given_measured_ == 0) FindGivenMeasured(poses);
  FoundPlan found = ChosenOf(poses, Approximate(poses, may_move() ? kOnTheWay : kTolerance));
  if (request_.found) request_.found({poses, Rms(found.covariance)});
  if (!may_move()) return found;
  if (request_.progress) request_.progress("moving " + std::to_string(poses) + " poses");
  MovePoses(&found);
  found.approximate = Approximate(poses, kTolerance);
  // Where few poses are feasible what moved is most of what there is to choose from.
  for (int turn = 0; turn < kMostTurns && !IsNextToBest(found); ++turn) {
    FoundPlan anew = ChosenOf(poses, found.approximate);
    MovePoses(&anew);
    anew.approximate = Approximate(poses, kTolerance);
    const double saved = found.cost - anew.cost;
    if (saved > 0.0) found = anew;
    found.approximate = anew.approximate;
    if (!(saved > kWorthATurn * std::abs(found.cost))) break;
  }
  return found;
}

double PlanSearch::Quick(int poses) {
  if (request_.progress) request_.progress("accuracy of " + std::to_string(poses) + " poses");
  if (numbers_->set.size() > kShortList && short_list_.first.empty()) {
    const ApproximateDesign design = Approximate(poses, kOnTheWay);
    short_list_ = numbers_->set.Subset(Foremost(design.gain, kShortList));
  }
  // The list stays that of the first number; what joined since is left out.
  const CandidateSet& set = short_list_.first.empty() ? numbers_->set : short_list_;
  ExactOptions options;
  options.repeats = request_.candidates == nullptr;
  options.starts = 1;
  options.rounds = 3;
  options.max_trials = 150;
  const bool is_started = quick_weights_.size() == set.size();
  const ApproximateDesign design =
      SolveApproximate(set, numbers_->known, criterion_, poses, kOnTheWay, 300, is_started ? &quick_weights_ : nullptr);
  quick_weights_ = design.weights;
  const ExactDesign exact = SolveExact(set, numbers_->known, criterion_, poses, design, options);
  curve_.push_back({poses, Rms(exact.covariance)});
  if (request_.found) request_.found(curve_.back());
  return curve_.back().position_rms;
}

FoundPlan PlanSearch::Reaching(double accuracy) {
  const bool may_repeat = request_.candidates == nullptr;
  const int limit = may_repeat ? request_.most_poses : std::min(request_.most_poses, numbers_->set.size());
  int low = numbers_->LeastPoses() - 1;
  int high = std::min(low + 1, limit);
  double rms = Quick(high);
  while (rms > accuracy) {
    if (high == limit) {
      throw InputError({"", 0, "--accuracy_mm"},
                       "even " + std::to_string(limit) + " poses leave " + Significant(1e3 * rms * Widening(), 3) +
                           " mm at the test poses",
                       "ask for less accuracy, measure more exactly, or at test poses nearer to the candidates");
    }
    low = high;
    high = std::min(2 * high, limit);
    rms = Quick(high);
  }
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (Quick(middle) <= accuracy ? high : low) = middle;
  }
  // A thorough search may need fewer, hardly ever more.
  FoundPlan best = At(high);
  while (Rms(best.covariance) > accuracy && high < limit) best = At(++high);
  while (high - 1 >= numbers_->LeastPoses()) {
    FoundPlan fewer = At(high - 1);
    if (Rms(fewer.covariance) > accuracy) break;
    best = std::move(fewer);
    --high;
  }
  return best;
}

void PlanSearch::Extend(int poses) {
  const bool may_repeat = request_.candidates == nullptr;
  const int least = numbers_->LeastPoses(), most = may_repeat ? request_.most_poses : numbers_->set.size();
  for (const double share : {0.5, 0.71, 1.0, 1.41, 2.0, 2.83}) {  // by sqrt(2), over which averaging gains 16 %
    const int other = static_cast<int>(std::lround(share * poses));
    const auto same = [&](const PosesAndAccuracy& point) { return point.poses == other; };
    if (other < least || other > most || std::any_of(curve_.begin(), curve_.end(), same)) continue;
    Quick(other);
  }
}

std::vector<PosesAndAccuracy> PlanSearch::Curve() const {
  std::vector<PosesAndAccuracy> curve;
  for (const PosesAndAccuracy& point : curve_) {  // the best of each number
    const auto same = std::find_if(curve.begin(), curve.end(),
                                   [&](const PosesAndAccuracy& other) { return other.poses == point.poses; });
    if (same == curve.end()) {
      curve.push_back(point);
    } else {
      same->position_rms = std::min(same->position_rms, point.position_rms);
    }
  }
  std::sort(curve.begin(), curve.end(), [](const auto& a, const auto& b) { return a.poses < b.poses; });
  return curve;
}

int PlanSearch::Knee() const {
  constexpr double kAveraging = 0.6;  // where more poses only average, accuracy falls as n^-1/2; a fifth more is a gain
  const std::vector<PosesAndAccuracy> curve = Curve();
  for (size_t i = 0; i + 1 < curve.size(); ++i) {
    const double falls = std::log(curve[i].position_rms / curve[i + 1].position_rms);
    const double grows = std::log(static_cast<double>(curve[i + 1].poses) / curve[i].poses);
    if (falls <= kAveraging * grows) return curve[i].poses;
  }
  return 0;
}

}  // namespace sagitta
