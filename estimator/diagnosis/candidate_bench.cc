#include "estimator/diagnosis/candidate_bench.h"

#include <algorithm>
#include <cmath>

namespace sagitta {
namespace {

// Whether the only column would have to be absurdly large. typical: size of it, in its units.
bool IsOversized(const NormalEquations& normal, double typical) {
  if (normal.gradient.size() != 1 || normal.information(0, 0) <= 0.0) return false;
  return std::abs(normal.gradient[0]) > kOversized * typical * normal.information(0, 0);
}

// Of the best shape; the shape counts as parameters.
Score ScoreOfShapes(const std::vector<CompensatorShape>& shapes, long rows) {
  Score score;
  if (shapes.empty()) return score;
  score.reduction = shapes[0].reduction;
  score.rank = kCompensatorParameters;
  score.penalised = score.reduction - score.rank * std::log(static_cast<double>(rows));
  return score;
}

}  // namespace

CandidateBench::CandidateBench(const CalibrationProblem& problem, const ParameterSet& parameters,
                               std::vector<Candidate> candidates)
    : candidates_(std::move(candidates)), columns_(ColumnsOf(problem, parameters, SpecsOf(candidates_))) {
  Eigen::MatrixXd deviations;
  for (const Candidate& candidate : candidates_) {
    if (candidate.spec.effect != "gravity_compensator") continue;
    const std::string& joint = candidate.spec.target;
    if (deviations.size() == 0) deviations = JointDeviationColumns(problem, parameters);
    const Eigen::VectorXd deviation = deviations.col(problem.robot.chain.FindJoint(joint));
    seats_.emplace(joint, SeatOf(problem, parameters, joint, deviation));
  }
}

CandidateBench CandidateBench::OnRows(const std::vector<int>& rows) const {
  CandidateBench part = *this;
  part.columns_.columns = columns_.columns(rows, Eigen::all);
  for (auto& [joint, seat] : part.seats_) {
    seat.angles = seats_.at(joint).angles(rows);
    seat.deviation = seats_.at(joint).deviation(rows);
  }
  return part;
}

Screening::Screening(const CandidateBench& bench, const ProjectedResidual& residual, bool has_spring)
    : bench_(bench),
      residual_(residual),
      on_believed_(residual.OnBelieved(bench.columns().columns)),
      has_spring_(has_spring) {}

CandidateScore Screening::Of(int candidate) const {
  CandidateScore result;
  const Candidate& own = bench_.candidates()[candidate];
  const long rows = residual_.residual().size();
  if (own.spec.effect == "gravity_compensator") {
    if (has_spring_) return result;
    result.shapes = ScanCompensator(bench_.seat(own.spec.target), residual_);
    result.score = ScoreOfShapes(result.shapes, rows);
    return result;
  }
  const CandidateColumns& all = bench_.columns();
  const int first = all.first[candidate], count = all.count(candidate);
  if (count == 0) return result;
  NormalEquations normal =
      residual_.ReduceBlock(all.columns.middleCols(first, count), on_believed_.middleCols(first, count));
  const std::vector<int> kept = InformedColumns(normal, all.typical.segment(first, count));
  for (int c = 0; c < count; ++c) {
    if (std::find(kept.begin(), kept.end(), c) == kept.end()) {
      result.vague.push_back(all.names[first + c]);
    } else {
      result.informed.push_back(first + c);
    }
  }
  result.oversized = IsOversized(normal, all.typical[first]);
  if (!result.vague.empty()) {
    normal = {Eigen::MatrixXd(normal.information(kept, kept)), Eigen::VectorXd(normal.gradient(kept))};
  }
  result.score = ScoreOf(normal, rows, own.settings);
  return result;
}

double Screening::Reproduced(const CandidateScore& scored, const Eigen::VectorXd& target) const {
  double most = 0.0;
  for (const CompensatorShape& shape : scored.shapes) {
    most = std::max(most, residual_.Reproduce(shape.columns, target).squaredNorm());
  }
  if (scored.informed.empty()) return most;
  const Eigen::MatrixXd columns = bench_.columns().columns(Eigen::all, scored.informed);
  NormalEquations normal = residual_.ReduceBlock(columns, on_believed_(Eigen::all, scored.informed));
  normal.gradient = columns.transpose() * target;
  return ScoreOf(normal, target.size(), 1).reduction;
}

}  // namespace sagitta
