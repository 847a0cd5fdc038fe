// Instruments that read wrong: an azimuth, an elevation or a range is off by a function of such a reading, of each
// marker by its own.
#include <algorithm>
#include <cmath>
#include <set>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/scan.h"
#include "estimator/explanations/unnamed_list.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "models/effects/bump.h"
#include "models/sight.h"
#include "problems/io/units.h"

namespace sagitta {
namespace {

// Waves over the range are tried in quarters over its span: the nearest is at most pi / 8 off in phase at its ends and
// leaves (pi / 8)^2 / 3 = 5 % of the square of any. From one wave on: longer ones are an offset and a scale, but for
// little.
constexpr int kFewestQuarters = 4;
constexpr int kMostQuarters = 400;
constexpr size_t kRangeWaves = 4;  // the best ones

const char* NameOf(Sensed angle) { return angle == Sensed::kAzimuth ? "azimuth" : "elevation"; }

class ReadingFunctions : public UnnamedList {
 public:
  using UnnamedList::UnnamedList;

  std::vector<UnnamedGroup> List() {
    for (size_t s = 0; s < problem_.data().stations.size(); ++s) {
      const int station = static_cast<int>(s);
      SetRead(station);
      if (read_.empty()) continue;
      AddBumps(station);
      AddWaves(station);
    }
    return Take();
  }

 private:
  struct Read {
    int marker, shot;
    bool is_fitted;
    double azimuth, elevation, range;  // rad and m; the azimuth from that of the middle of the fitted

    double Of(Sensed reading) const {
      return reading == Sensed::kRange ? range : reading == Sensed::kAzimuth ? azimuth : elevation;
    }
  };

  // Points that the station measured.
  void SetRead(int station) {
    read_.clear();
    markers_.clear();
    const std::set<int> fitted(fitted_.begin(), fitted_.end());
    const Measurements& data = problem_.data();
    std::vector<Vector3<double>> seen;
    Vector3<double> middle = Vector3<double>::Zero();
    for (const Observation& one : data.observations) {
      if (data.shots[one.shot].station != station || !one.is_point() || !one.point_in_station.allFinite()) continue;
      seen.push_back(one.point_in_station - problem_.shot_inputs()[one.shot].conditions.instrument);
      read_.push_back({one.marker, one.shot, fitted.count(one.shot) > 0, 0.0, 0.0, seen.back().norm()});
      if (read_.back().is_fitted) middle += seen.back();
    }
    middle_azimuth_ = std::atan2(middle.y(), middle.x());
    for (size_t i = 0; i < read_.size(); ++i) {
      const Vector3<double>& d = seen[i];
      read_[i].azimuth = std::remainder(std::atan2(d.y(), d.x()) - middle_azimuth_, 2.0 * kPi);
      read_[i].elevation = std::atan2(d.z(), std::hypot(d.x(), d.y()));
      if (read_[i].is_fitted) markers_.insert(read_[i].marker);
    }
  }

  // Of the fitted ones.
  Eigen::VectorXd FittedOf(Sensed reading) const {
    std::vector<double> values;
    for (const Read& read : read_) {
      if (read.is_fitted) values.push_back(read.Of(reading));
    }
    return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
  }

  // Of a marker, shots x functions; zero where it was not read.
  template <typename Functions>
  Eigen::MatrixXd Of(int marker, Sensed reading, const Functions& functions) const {
    const auto shots = static_cast<long>(problem_.data().shots.size());
    Eigen::VectorXd values = Eigen::VectorXd::Zero(shots), is_read = values;
    for (const Read& read : read_) {
      if (read.marker != marker) continue;
      values[read.shot] = read.Of(reading);
      is_read[read.shot] = 1.0;
    }
    return is_read.asDiagonal() * functions(values);
  }

  std::vector<Source> SourcesOf(int station, Sensed reading) const {
    std::vector<Source> sources;
    for (const int marker : markers_)
      sources.push_back({Source::Kind::kReading, station, static_cast<int>(reading), marker});
    return sources;
  }

  // The circles, the axes of the instrument and the air that bends its ray, by where it looks. How an angle goes with
  // the range and the range with itself the catalogue says (station_refraction, station_range_offset, station_scale),
  // but for waves.
  void AddBumps(int station) {
    for (const Sensed reads : {Sensed::kAzimuth, Sensed::kElevation}) {
      for (const Sensed by : {Sensed::kAzimuth, Sensed::kElevation}) AddBumps(station, reads, by);
    }
  }

  // As OverKnots; azimuths are the same after a turn.
  static Eigen::MatrixXd BumpsOf(Sensed by, const Eigen::VectorXd& x, const Knots& knots) {
    Eigen::MatrixXd bumps(x.size(), knots.count);
    for (int k = 0; k < knots.count; ++k) {
      bumps.col(k) = x.unaryExpr([&](double at) {
        const double off = at - knots.At(k);
        return Bump(by == Sensed::kAzimuth ? std::remainder(off, 2.0 * kPi) : off, 0.0, knots.Apart());
      });
    }
    return bumps;
  }

  void AddBumps(int station, Sensed reads, Sensed by) {
    const std::string& name = problem_.data().stations[station];
    const Eigen::VectorXd fitted = FittedOf(by);
    if (fitted.size() == 0) return;
    const double low = fitted.minCoeff(), high = fitted.maxCoeff();
    if (!(high - low > 1e-9)) return;  // rad
    const double middle = by == Sensed::kAzimuth ? middle_azimuth_ : 0.0;
    const EffectSpec effect{"learnt_reading",
                            name,
                            {{"reads", NameOf(reads)},
                             {"by", std::string(NameOf(by)) + "_deg"},
                             {"from", AsSetting((middle + low) / kDegree)},
                             {"to", AsSetting((middle + high) / kDegree)}},
                            {}};
    std::vector<GroupedFunctions> of_source;
    for (const int marker : markers_) {
      GroupedFunctions functions;
      for (const int count : kUnnamedBumps) {
        const Knots knots{low, high, count};
        const auto bumps = [&knots, by](const auto& x) { return BumpsOf(by, x, knots); };
        functions.Append(Of(marker, by, bumps), "other", {{"knots", std::to_string(count)}});
      }
      of_source.push_back(std::move(functions));
    }
    AddEach(of_source,
            UnnamedFunction(name, {name}, ReadsWrongOver(name, NameOf(reads), NameOf(by)), SourcesOf(station, reads),
                            {effect}),
            "reading", markers_.size());
  }

  // Waves of one period, of each marker.
  std::vector<GroupedFunctions> WavesOf(const std::string& period_mm, double listed) const {
    const double period = 1e-3 * ParseNumber(period_mm).value();
    std::vector<GroupedFunctions> of_source;
    for (const int marker : markers_) {
      GroupedFunctions functions;
      const auto wave = [period](const auto& x) { return Wave(2.0 * kPi / period * x); };
      functions.Append(Of(marker, Sensed::kRange, wave), "other", {{"period_mm", period_mm}}, "", listed);
      of_source.push_back(std::move(functions));
    }
    return of_source;
  }

  // Ranges of the fitted readings in units of a length, with the square of what a metre of each moves and its product
  // with the residual.
  struct Ranges {
    Eigen::ArrayXd at, square, residual;

    Eigen::ArrayXcd WaveOf(double n) const { return Turn(2.0 * kPi * n * at); }

    // What a wave explains of chi-square by itself: b'A^-1 b of its cosine and sine.
    double Reduction(const Eigen::ArrayXcd& wave) const {
      const Eigen::ArrayXd c = wave.real(), s = wave.imag();
      Eigen::Matrix2d all;
      all << (square * c * c).sum(), (square * c * s).sum(), (square * c * s).sum(), (square * s * s).sum();
      const Eigen::Vector2d along((residual * c).sum(), (residual * s).sum());
      return all.determinant() > 0.0 ? along.dot(all.inverse() * along) : 0.0;
    }
    double Reduction(double n) const { return Reduction(WaveOf(n)); }
  };

  Ranges RangesOf(const AlongSources& along, double unit) const {
    std::vector<double> at, square, residual;
    long source = 0;
    for (const int marker : markers_) {
      const Eigen::MatrixXd ranges = Of(marker, Sensed::kRange, [](const auto& x) { return x; });
      for (long shot = 0; shot < ranges.rows(); ++shot) {
        if (!(along.square(shot, source) > 0.0)) continue;
        at.push_back(ranges(shot, 0) / unit);
        square.push_back(along.square(shot, source));
        residual.push_back(along.residual(shot, source));
      }
      ++source;
    }
    const auto of = [](const std::vector<double>& values) -> Eigen::ArrayXd {
      return Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<long>(values.size()));
    };
    return {of(at), of(square), of(residual)};
  }

  // Of all waves those that say most of the rows, and more than their neighbours, each by itself.
  void AddWaves(int station) {
    const std::string& name = problem_.data().stations[station];
    const std::vector<Source> sources = SourcesOf(station, Sensed::kRange);
    const std::vector<double> distinct = Distinct(FittedOf(Sensed::kRange));
    const int most = std::min<int>(kMostQuarters, 2 * distinct.size());  // down to two readings
    if (most < kFewestQuarters) return;
    const double four_spans = 4.0 * (distinct.back() - distinct.front());
    const Ranges ranges = RangesOf(columns_->SumAlong(sources), four_spans);
    std::vector<double> tried = {0.0};
    const Eigen::ArrayXcd turn = ranges.WaveOf(1.0);
    Eigen::ArrayXcd wave = ranges.WaveOf(kFewestQuarters);
    for (int n = kFewestQuarters; n <= most; ++n, wave *= turn) tried.push_back(ranges.Reduction(wave));
    tried.push_back(0.0);
    Scan<double> peaks;
    for (size_t i = 1; i + 1 < tried.size(); ++i) {
      const bool is_peak = tried[i] > tried[i - 1] && tried[i] >= tried[i + 1];
      if (is_peak) peaks.Try(tried[i], kFewestQuarters + static_cast<double>(i) - 1.0);
    }
    const std::vector<double> best = peaks.Best(kRangeWaves);
    const double listed = static_cast<double>(best.size()) / static_cast<double>(tried.size() - 2);
    for (const double quarters : best) {
      const double period = 1e3 * four_spans / Refined(ranges, quarters);
      AddEach(WavesOf(AsSetting(period), listed),
              UnnamedFunction(name, {name}, RangeRepeats(name, Significant(period, 3)), sources,
                              {{"learnt_range_wave", name, {}, {}}}),
              "range wave", markers_.size());
    }
  }

  // The top of a peak, to a sixteenth of a quarter.
  static double Refined(const Ranges& ranges, double quarters) {
    double most = ranges.Reduction(quarters);
    for (double step = 0.5; step > 0.05; step *= 0.5) {
      const double centre = quarters;
      for (const double at : {centre - step, centre + step}) {
        const double here = ranges.Reduction(at);
        if (here <= most) continue;
        most = here;
        quarters = at;
      }
    }
    return quarters;
  }

  std::vector<Read> read_;
  std::set<int> markers_;  // of which a reading is fitted
  double middle_azimuth_ = 0.0;
};

}  // namespace

std::vector<UnnamedGroup> ListUnnamedReadings(const CalibrationProblem& problem, EvidenceColumns* columns) {
  return ReadingFunctions(problem, columns).List();
}

}  // namespace sagitta
