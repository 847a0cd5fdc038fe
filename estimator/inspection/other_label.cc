#include "estimator/inspection/other_label.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "estimator/alignment/aligned_misfit.h"
#include "estimator/alignment/starting_values.h"
#include "estimator/inspection/affine_in_marker.h"
#include "estimator/inspection/moved_rows.h"
#include "estimator/inspection/reading_lint.h"
#include "estimator/inspection/tried_readings.h"
#include "estimator/least_squares/linearization.h"
#include "models/quantiles.h"

namespace sagitta {
namespace {

constexpr size_t kFewestOfPose = 4;    // rows: 12 numbers to a pose of six
constexpr size_t kFewestOfMarker = 3;  // rows: 9 numbers to a point of three
constexpr size_t kFewestPoses = 3;     // the rows of one are a pose wherever its joints are: any fits some station
constexpr double kOnePoint = 1e-3;     // of the reach: points of different poses lie tenths of it apart

void SetFound(OtherLabel::Kind kind, const std::string& stated, const std::string& fits, OtherLabel* found) {
  found->kind = kind;
  found->stated = stated;
  found->fits = fits;
}

Vector3<double> ToBase(const Pose<double>& base, const Vector3<double>& point) {
  return base.rotation.transpose() * (point - base.translation);
}

Eigen::Matrix3Xd PointsOfRows(const CalibrationProblem& problem, const std::vector<int>& rows) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(rows.size()));
  for (size_t k = 0; k < rows.size(); ++k) {
    points.col(static_cast<Eigen::Index>(k)) = problem.data().observations[rows[k]].point_in_station;
  }
  return points;
}

double RmsDistance(const Eigen::Matrix3Xd& differences) {
  return differences.norm() / std::sqrt(static_cast<double>(std::max<Eigen::Index>(1, differences.cols())));
}

// The far rows of one station and one marker, and what else could have made them.
class LabelGroup {
 public:
  LabelGroup(const CalibrationProblem& problem, const FarRows& all)
      : problem_(problem),
        all_(all),
        marker_(RowOf(all.far.front()).marker),
        station_(StationOf(all.far.front())),
        measured_(PointsOfRows(problem, all.far)) {
    for (size_t k = 0; k < all.far.size(); ++k) {
      one_marker_ = one_marker_ && RowOf(all.far[k]).marker == marker_;
      one_station_ = one_station_ && StationOf(all.far[k]) == station_;
    }
  }

  // Every row with the pose of the other station that fits it best, as when labels are exchanged.
  bool FitsOtherStations(OtherLabel* found) const {
    if (static_cast<int>(problem_.data().stations.size()) < 2) return false;
    const Eigen::Matrix3Xd points = PointsInBase(all_.parameters);
    std::vector<std::string> fits;
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      double least = std::numeric_limits<double>::infinity();
      int nearest = -1;
      const int own = StationOf(all_.far[static_cast<size_t>(k)]);
      for (int s = 0; s < static_cast<int>(problem_.data().stations.size()); ++s) {
        const double distance = (all_.parameters.BaseInStation(s) * points.col(k) - measured_.col(k)).norm();
        if (s == own || !(distance < least)) continue;
        least = distance;
        nearest = s;
      }
      if (!(least <= kFarApart * all_.near_rms)) return false;
      fits.push_back(problem_.data().stations[nearest]);
    }
    SetFound(OtherLabel::Kind::kOtherStation, problem_.data().stations[StationOf(all_.far.front())], fits.front(),
             found);
    found->fits_of_row = fits;
    return true;
  }

  bool FitsOwnStation(OtherLabel* found) const {
    std::set<int> configurations;
    for (const int i : all_.far) configurations.insert(problem_.data().shots[RowOf(i).shot].configuration);
    if (!one_station_ || configurations.size() < kFewestPoses) return false;
    const Eigen::Matrix3Xd points = PointsInBase(all_.parameters);
    const Eigen::Matrix4d motion = Eigen::umeyama(points, measured_, false);
    if (!motion.allFinite()) return false;
    Pose<double> base;
    base.rotation = motion.topLeftCorner<3, 3>();
    base.translation = motion.topRightCorner<3, 1>();
    if (!Fits(base, points)) return false;
    SetFound(OtherLabel::Kind::kOwnStation, problem_.data().stations[station_], "", found);
    const Pose<double> stated = all_.parameters.BaseInStation(station_);
    const Vector3<double> origin = Vector3<double>::Zero();
    found->moved = (ToBase(base, origin) - ToBase(stated, origin)).norm();
    found->turned = std::abs(Eigen::AngleAxisd(stated.rotation.transpose() * base.rotation).angle());
    return true;
  }

  bool FitsMarker(OtherLabel* found) const {
    if (!one_marker_) return false;
    const AffineInMarker points(problem_, all_.parameters, all_.far, marker_);
    const Vector3<double> mean = points.Best(measured_);
    const auto fits = [&](const Vector3<double>& m) { return IsNear(points.At(m)); };
    for (int other = 0; other < static_cast<int>(problem_.data().markers.size()); ++other) {
      if (other == marker_ || problem_.marker_frames()[other] != problem_.marker_frames()[marker_]) continue;
      if (!fits(all_.parameters.MarkerPoint(other))) continue;
      SetFound(OtherLabel::Kind::kOtherMarker, problem_.data().markers[marker_], problem_.data().markers[other], found);
      return true;
    }
    if (!fits(mean)) return false;
    SetFound(OtherLabel::Kind::kOwnMarker, problem_.data().markers[marker_], "", found);
    found->moved = (mean - all_.parameters.MarkerPoint(marker_)).norm();
    return true;
  }

 private:
  const Observation& RowOf(int i) const { return problem_.data().observations[i]; }
  int StationOf(int i) const { return problem_.data().shots[RowOf(i).shot].station; }

  Eigen::Matrix3Xd PointsInBase(const ParameterSet& parameters) const {
    Eigen::Matrix3Xd points = PredictPoints(problem_, parameters, all_.far);
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      points.col(k) = ToBase(parameters.BaseInStation(StationOf(all_.far[static_cast<size_t>(k)])), points.col(k));
    }
    return points;
  }

  bool Fits(const Pose<double>& base, const Eigen::Matrix3Xd& points) const {
    Eigen::Matrix3Xd moved = points;
    for (Eigen::Index k = 0; k < points.cols(); ++k) moved.col(k) = base * Vector3<double>(points.col(k));
    return IsNear(moved);
  }

  // As the others fit: RMS distance.
  bool IsNear(const Eigen::Matrix3Xd& predicted) const { return RmsDistance(predicted - measured_) <= all_.limit; }

  const CalibrationProblem& problem_;
  const FarRows& all_;
  int marker_, station_;
  bool one_marker_ = true, one_station_ = true;
  Eigen::Matrix3Xd measured_;
};

// Where in the order of measurement the far rows of a station begin, or end, if the others are all on the other side.
void FindMove(const CalibrationProblem& problem, const FarRows& rows, OtherLabel* found) {
  const auto station = [&](int i) { return problem.data().shots[problem.data().observations[i].shot].station; };
  std::vector<int> both = rows.far;
  std::copy_if(rows.near.begin(), rows.near.end(), std::back_inserter(both),
               [&](int i) { return station(i) == station(rows.far.front()); });
  std::sort(both.begin(), both.end());
  const std::set<int> far(rows.far.begin(), rows.far.end());
  int changes = 0;
  both = InOrderOfMeasurement(problem.data(), both);
  for (size_t k = 1; k < both.size(); ++k) {
    if (far.count(both[k]) == far.count(both[k - 1])) continue;
    ++changes;
    found->last_before = both[k - 1];
    found->first_after = both[k];
  }
  if (changes != 1) found->last_before = found->first_after = -1;
}

}  // namespace

std::optional<OtherLabel> FindOtherLabel(const CalibrationProblem& problem, FarRows rows) {
  rows = OnlyThoseApart(std::move(rows));
  if (rows.far.size() < kFewestOfPose || !AreApart(rows, problem)) return std::nullopt;
  const LabelGroup group(problem, rows);
  OtherLabel found;
  if (!group.FitsOtherStations(&found) && !group.FitsMarker(&found) && !group.FitsOwnStation(&found)) {
    return std::nullopt;
  }
  found.far = rows.far;
  found.rows = rows.far.size() + rows.near.size();
  found.far_median = rows.far_median;
  if (found.kind == OtherLabel::Kind::kOwnStation) FindMove(problem, rows, &found);
  return found;
}

std::optional<OtherLabel> FindOtherFrame(const CalibrationProblem& problem) {
  const Chain& chain = problem.robot().chain;
  const double suspicious = SuspiciousMisfit(problem);
  const std::vector<int> points = problem.data().PointsAmong(problem.CalibrationObservations());
  for (int marker = 0; marker < static_cast<int>(problem.data().markers.size()); ++marker) {
    std::vector<int> own, others;
    for (const int i : points) (problem.data().observations[i].marker == marker ? own : others).push_back(i);
    if (own.size() < kFewestOfMarker || others.size() < own.size()) continue;
    ParameterSet parameters = problem.parameters;
    if (!(FindStartingValues(problem, others, &parameters) <= suspicious)) continue;
    const Eigen::Matrix3Xd measured = PointsOfRows(problem, own);
    CalibrationProblem trial = problem;
    const auto misfit_on = [&](int frame) {
      trial.set_marker_frame(marker, frame);
      const AffineInMarker at(trial, parameters, own, marker);
      return RmsDistance(at.At(at.Best(measured)) - measured);
    };
    const double stated = misfit_on(problem.marker_frames()[marker]);
    if (stated <= suspicious) continue;
    OtherLabel found;
    double least = std::min(suspicious, stated / kReadingImprovement);
    for (int joint = -1; joint < chain.num_joints(); ++joint) {
      const double misfit = misfit_on(joint < 0 ? 0 : chain.FrameAfterJoint(joint));
      if (!(misfit < least)) continue;
      least = misfit;
      found.place = joint < 0 ? MarkerPlace{MarkerPlace::Kind::kBase, ""}
                              : MarkerPlace{MarkerPlace::Kind::kJoint, chain.joints[joint].name};
      SetFound(OtherLabel::Kind::kOtherFrame, problem.data().markers[marker], found.place.Word(), &found);
    }
    if (found.fits.empty()) continue;
    found.moved = least;
    found.far_median = stated;
    found.far = own;
    found.rows = points.size();
    return found;
  }
  return std::nullopt;
}

bool AreAllOnePoint(const CalibrationProblem& problem, double* spread) {
  const std::vector<int> fitted = problem.data().PointsAmong(problem.CalibrationObservations());
  double squares = 0.0;
  Eigen::Index count = 0;
  for (const auto& [station, rows] : ByStation(problem.data(), fitted)) {
    Eigen::Matrix3Xd points = PointsOfRows(problem, rows);
    points.colwise() -= Vector3<double>(points.rowwise().mean());
    squares += points.squaredNorm();
    count += points.cols();
  }
  *spread = std::sqrt(squares / static_cast<double>(std::max<Eigen::Index>(1, count)));
  return count > 1 && *spread < kOnePoint * Reach(problem.robot().chain);
}

}  // namespace sagitta
