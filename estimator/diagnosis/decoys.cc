#include "estimator/diagnosis/decoys.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace sagitta {
namespace {

constexpr int kSmoothBumps[] = {6, 12, 24};  // over the range: what is smooth at one width is not at another
constexpr int kKindBumps = 24;
constexpr int kMostPlaces = 48;                                   // of a scanned bump or step
constexpr double kBumpWidths[] = {0.01, 0.02, 0.04, 0.08, 0.16};  // standard deviation over the range
constexpr int kOrders = 6;
constexpr int kPeriods = 100;  // half cycles over the data
constexpr double kTwoPi = 6.283185307179586;
constexpr double kDegree = 57.29577951308232;

std::string Rounded(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string Range(const Eigen::VectorXd& x) {
  return Rounded("%.0f", x.minCoeff() * kDegree) + " to " + Rounded("%.0f", x.maxCoeff() * kDegree) + " deg";
}

// Gaussian bumps evenly over the range, one standard deviation apart.
Eigen::MatrixXd Bumps(const Eigen::VectorXd& x, int count) {
  const double low = x.minCoeff(), spacing = (x.maxCoeff() - low) / (count - 1);
  Eigen::MatrixXd bumps(x.size(), count);
  for (int b = 0; b < count; ++b) {
    bumps.col(b) = (-0.5 * ((x.array() - (low + b * spacing)) / spacing).square()).exp();
  }
  return bumps;
}

}  // namespace

// One search over all decoys on one residual.
class DecoySearch {
 public:
  DecoySearch(const DecoyBench& bench, const ProjectedResidual& residual)
      : problem_(bench.problem_),
        bench_(bench),
        residual_(residual),
        deviations_(bench.deviations_),
        angles_(bench.angles_),
        time_(bench.time_) {}

  Decoy Best() {
    const int n = problem_.robot.num_joints();
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        if (angles_[k].maxCoeff() - angles_[k].minCoeff() < 1e-6) continue;
        TrySmooth(j, angles_[k], {Name(k)}, "smooth", Name(k) + " (" + Range(angles_[k]) + ")", n);
        if (k == j) TryPlaces(j);
        if (k != j) TryHarmonics(j, k);
      }
      for (int a = 0; a < n; ++a) {
        for (int b = a + 1; b < n; ++b) TryProduct(j, a, b);
      }
      if (bench_.timed_) TrySmooth(j, time_, {Name(j)}, "time", "time", n);
    }
    if (bench_.timed_) TryWaves();
    return best_;
  }

 private:
  const std::string& Name(int joint) const { return problem_.robot.chain.joints[joint].name; }

  // Penalised reductions of single columns side by side, `settings` scanned.
  Eigen::VectorXd SingleGains(const Eigen::MatrixXd& columns, int settings, Eigen::VectorXd* sizes) const {
    const Eigen::ArrayXd squared = residual_.SquaredOff(columns).array().max(1e-300);
    const Eigen::ArrayXd projected = (columns.transpose() * residual_.residual()).array();
    *sizes = -(projected / squared).matrix();
    const Eigen::ArrayXd whole = columns.colwise().squaredNorm().transpose().array();
    const Eigen::ArrayXd told = (squared > 1e-6 * whole).cast<double>();
    const double rows = static_cast<double>(residual_.residual().size());
    return (told * projected.square() / squared - std::log(rows) - 2.0 * std::log(settings)).matrix();
  }

  void Keep(Decoy decoy) {
    if (decoy.penalised > best_.penalised) best_ = std::move(decoy);
  }

  void TrySmooth(int j, const Eigen::VectorXd& x, std::vector<std::string> depends_on, const std::string& kind,
                 const std::string& on, int drivers) {
    const double scanned = 2.0 * std::log(drivers * (sizeof(kSmoothBumps) / sizeof(kSmoothBumps[0])));
    for (const int count : kSmoothBumps) {
      const Eigen::MatrixXd columns = deviations_.col(j).asDiagonal() * Bumps(x, count);
      Decoy decoy{kind, depends_on, Name(j), "", residual_.MarginalGain(columns) - scanned, columns};
      decoy.words = "a smooth deviation of " + Name(j) + " that depends on " + on;
      Keep(std::move(decoy));
    }
  }

  // One bump or one step along the joint's own angle, at the angles that the
  // data have.
  void TryPlaces(int j) {
    const Eigen::ArrayXd& q = angles_[j].array();
    const double span = q.maxCoeff() - q.minCoeff();
    const std::vector<double> places = Places(angles_[j]);
    constexpr int kWidths = sizeof(kBumpWidths) / sizeof(kBumpWidths[0]);
    const int count = static_cast<int>(places.size());
    Eigen::MatrixXd bumps(q.size(), count * kWidths), steps(q.size(), count - 1);
    for (int p = 0; p < count; ++p) {
      if (p + 1 < count) {
        steps.col(p) = deviations_.col(j).array() * (q > 0.5 * (places[p] + places[p + 1])).cast<double>();
      }
      for (int w = 0; w < kWidths; ++w) {
        bumps.col(p * kWidths + w) =
            deviations_.col(j).array() * (-0.5 * ((q - places[p]) / (kBumpWidths[w] * span)).square()).exp();
      }
    }
    Eigen::VectorXd sizes;
    int at = 0;
    const double bump = SingleGains(bumps, static_cast<int>(bumps.cols()), &sizes).maxCoeff(&at);
    if (bump > best_.penalised) {
      const double center = places[at / kWidths] * kDegree, reach = 1.5 * kBumpWidths[at % kWidths] * span * kDegree;
      Keep({"smooth",
            {Name(j)},
            Name(j),
            "a bump of " + Name(j) + " between " + Rounded("%.0f", center - reach) + " and " +
                Rounded("%.0f", center + reach) + " deg, " + Rounded("%.3g", 1e-3 * sizes[at]) + " mrad high",
            bump,
            bumps.col(at)});
    }
    if (count < 2) return;
    const double step = SingleGains(steps, count - 1, &sizes).maxCoeff(&at);
    if (step > best_.penalised) {
      const double place = 0.5 * (places[at] + places[at + 1]) * kDegree;
      Keep({"step",
            {Name(j)},
            Name(j),
            "a step of " + Name(j) + " by " + Rounded("%.3g", 1e-3 * sizes[at]) + " mrad at " + Rounded("%.0f", place) +
                " deg",
            step,
            steps.col(at)});
    }
  }

  // Distinct values, thinned.
  static std::vector<double> Places(const Eigen::VectorXd& x) {
    const std::set<double> distinct(x.data(), x.data() + x.size());
    const std::vector<double> sorted(distinct.begin(), distinct.end());
    std::vector<double> places;
    const size_t stride = (sorted.size() + kMostPlaces - 1) / kMostPlaces;
    for (size_t i = stride / 2; i < sorted.size(); i += stride) places.push_back(sorted[i]);
    return places;
  }

  // Joint j deviates with the angle of another joint.
  void TryHarmonics(int j, int k) {
    for (int order = 1; order <= kOrders; ++order) {
      Eigen::MatrixXd columns(angles_[k].size(), 2);
      columns << deviations_.col(j).cwiseProduct((order * angles_[k]).array().cos().matrix()),
          deviations_.col(j).cwiseProduct((order * angles_[k]).array().sin().matrix());
      const int drivers = problem_.robot.num_joints() - 1;
      const Score score = residual_.Test(columns, kOrders * drivers);
      const double penalised = score.rank > 0 ? score.penalised : -1e300;
      if (penalised <= best_.penalised) continue;
      Keep({"periodic",
            {Name(k)},
            Name(j),
            "a deviation of " + Name(j) + " that repeats " + std::to_string(order) + " time(s) per turn of " + Name(k),
            penalised,
            columns});
    }
  }

  void TryProduct(int j, int a, int b) {
    const Eigen::ArrayXd p = angles_[a].array() - angles_[a].mean(), q = angles_[b].array() - angles_[b].mean();
    const Eigen::ArrayXd sum = angles_[a].array() + angles_[b].array();
    const Eigen::ArrayXd difference = angles_[a].array() - angles_[b].array();
    Eigen::MatrixXd basis(p.size(), 7);
    basis << (p * q).matrix(), sum.cos().matrix(), sum.sin().matrix(), difference.cos().matrix(),
        difference.sin().matrix(), (p.cos() * q).matrix(), (q.cos() * p).matrix();
    const Eigen::MatrixXd columns = deviations_.col(j).asDiagonal() * basis;
    const std::string words =
        "a deviation of " + Name(j) + " that depends on " + Name(a) + " and " + Name(b) + " together";
    const int n = problem_.robot.num_joints(), pairs = n * (n - 1) / 2;
    const double any = residual_.MarginalGain(columns) - 2.0 * std::log(2.0 * pairs);
    Keep({"other", {Name(a), Name(b)}, Name(j), words, any, columns});
    const Score product = residual_.Test(columns.col(0), 2 * pairs);
    const double penalised = product.rank > 0 ? product.penalised : -1e300;
    Keep({"other", {Name(a), Name(b)}, Name(j), words, penalised, columns.col(0)});
  }

  void TryWaves() {
    const double span = time_.maxCoeff() - time_.minCoeff();
    for (const std::string& station : problem_.data.stations) {
      const Eigen::MatrixXd shift = bench_.StationShift(station);
      Decoy best_wave{"time", {station}, station, "", -1e300, {}};
      for (int p = 1; p <= kPeriods; ++p) {
        const double omega = kTwoPi * (0.5 * p) / span;
        const Eigen::VectorXd c = (omega * time_).array().cos(), s = (omega * time_).array().sin();
        Eigen::MatrixXd columns(time_.size(), 6);
        columns << c.asDiagonal() * shift, s.asDiagonal() * shift;
        const double all = residual_.MarginalGain(columns) - 2.0 * std::log(4.0 * kPeriods);
        TryWave(all, columns, omega, "", &best_wave);
        for (int axis = 0; axis < 3; ++axis) {
          Eigen::MatrixXd own(time_.size(), 2);
          own << columns.col(axis), columns.col(3 + axis);
          const Score score = residual_.Test(own, 4 * kPeriods);
          const double penalised = score.rank > 0 ? score.penalised : -1e300;
          TryWave(penalised, own, omega, std::string(" in ") + "xyz"[axis], &best_wave);
        }
      }
      Keep(std::move(best_wave));
    }
  }

  static void TryWave(double penalised, const Eigen::MatrixXd& columns, double omega, const std::string& axis,
                      Decoy* best) {
    if (penalised <= best->penalised) return;
    best->penalised = penalised;
    best->columns = columns;
    best->words = "station " + best->acts_on + " moves" + axis + " with a period of about " +
                  Rounded("%.0f", kTwoPi / omega) + " s";
  }

  const CalibrationProblem& problem_;
  const DecoyBench& bench_;
  const ProjectedResidual& residual_;
  const Eigen::MatrixXd& deviations_;
  const std::vector<Eigen::VectorXd>& angles_;
  const Eigen::VectorXd& time_;
  Decoy best_;
};

DecoyBench::DecoyBench(const DiagnosedModel& model)
    : problem_(*model.problem),
      parameters_(model.estimate.parameters),
      residual_(LinearizeEstimate(problem_, parameters_)),
      deviations_(JointDeviationColumns(problem_, parameters_)) {
  const int n = problem_.robot.num_joints();
  for (int j = 0; j < n; ++j) angles_.push_back(PerRow([j](const ShotConditions& shot) { return shot.q[j]; }));
  timed_ = std::all_of(problem_.shot_inputs.begin(), problem_.shot_inputs.end(),
                       [](const ShotInput& shot) { return shot.conditions.has_time; });
  if (timed_) time_ = PerRow([](const ShotConditions& shot) { return shot.time; });
  timed_ = timed_ && time_.maxCoeff() > time_.minCoeff();
}

Decoy DecoyBench::Best(const ProjectedResidual& residual) const { return DecoySearch(*this, residual).Best(); }

Eigen::MatrixXd DecoyBench::ColumnsOfKind(const Decoy& decoy) const {
  std::vector<Eigen::MatrixXd> blocks = {decoy.columns};
  const int j = problem_.robot.chain.FindJoint(decoy.acts_on);
  if (j < 0) {  // a station
    const Eigen::MatrixXd shift = StationShift(decoy.acts_on);
    const Eigen::MatrixXd bumps = Bumps(time_, kKindBumps);
    for (int b = 0; b < kKindBumps; ++b) blocks.push_back(bumps.col(b).asDiagonal() * shift);
  } else if (decoy.kind == "time") {
    blocks.push_back(deviations_.col(j).asDiagonal() * Bumps(time_, kKindBumps));
  } else {
    for (const std::string& driver : decoy.depends_on) {
      const int k = problem_.robot.chain.FindJoint(driver);
      blocks.push_back(deviations_.col(j).asDiagonal() * Bumps(angles_[k], kKindBumps));
    }
  }
  Eigen::MatrixXd all(decoy.columns.rows(), 0);
  for (const Eigen::MatrixXd& block : blocks) {
    all.conservativeResize(Eigen::NoChange, all.cols() + block.cols());
    all.rightCols(block.cols()) = block;
  }
  return all;
}

// One scalar per 3 rows, from the shot of each observation.
Eigen::VectorXd DecoyBench::PerRow(const std::function<double(const ShotConditions&)>& value) const {
  const std::vector<int> observations = problem_.CalibrationObservations();
  Eigen::VectorXd rows(3 * observations.size());
  for (size_t k = 0; k < observations.size(); ++k) {
    const ShotInput& shot = problem_.shot_inputs[problem_.data.observations[observations[k]].shot];
    rows.segment<3>(3 * k).setConstant(value(shot.conditions));
  }
  return rows;
}

// How a shift of the station's points in x, y, z moves the rows, whitened, per
// um: the columns of its base position.
Eigen::MatrixXd DecoyBench::StationShift(const std::string& station) const {
  std::vector<int> columns;
  for (const char* axis : {"/x", "/y", "/z"}) columns.push_back(parameters_.FindCoordinate("base/" + station + axis));
  const std::vector<int> observations = problem_.CalibrationObservations();
  return 1e-6 * Linearize(problem_, parameters_, observations, columns, ObservationNoise(problem_, observations, 1e-3))
                    .jacobian;
}

}  // namespace sagitta
