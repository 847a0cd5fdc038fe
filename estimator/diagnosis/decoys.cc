#include "estimator/diagnosis/decoys.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace sagitta {
namespace {

constexpr int kSmoothBumps[] = {6, 12, 24};           // over the range: what is smooth at one width is not at another
constexpr int kPlaces = 24;                           // of a scanned bump or step
constexpr double kBumpWidths[] = {0.03, 0.06, 0.12};  // standard deviation over the range
constexpr int kOrders = 6;
constexpr int kPeriods = 24;
constexpr double kTwoPi = 6.283185307179586;
constexpr double kDegree = 57.29577951308232;

std::string Rounded(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

struct Gain {
  double penalised = -1e300;
  Eigen::VectorXd coefficients;  // of the columns, where they are one or two
};

// What every decoy is scored with: residual, and how joints and stations move the rows.
class Bench {
 public:
  explicit Bench(const DiagnosedModel& model)
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
    families_ = 5.0 * n * n + 0.5 * n * n * (n - 1) + (timed_ ? n + problem_.data.stations.size() : 0);
  }

  Decoy Best() {
    const int n = problem_.robot.num_joints();
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        if (angles_[k].maxCoeff() - angles_[k].minCoeff() < 1e-6) continue;
        TrySmooth(j, angles_[k], {Name(k)}, "smooth", Name(k) + " (" + Range(angles_[k]) + ")");
        TryPlaces(j, k);
        if (k != j) TryHarmonics(j, k);
      }
      for (int a = 0; a < n; ++a) {
        for (int b = a + 1; b < n; ++b) TryProduct(j, a, b);
      }
      if (timed_) TrySmooth(j, time_, {Name(j)}, "time", "time");
    }
    if (timed_) TryWaves();
    return best_;
  }

 private:
  const std::string& Name(int joint) const { return problem_.robot.chain.joints[joint].name; }

  // One scalar per 3 rows, from the shot of each observation.
  Eigen::VectorXd PerRow(const std::function<double(const ShotConditions&)>& value) const {
    const std::vector<int> observations = problem_.CalibrationObservations();
    Eigen::VectorXd rows(3 * observations.size());
    for (size_t k = 0; k < observations.size(); ++k) {
      const ShotInput& shot = problem_.shot_inputs[problem_.data.observations[observations[k]].shot];
      rows.segment<3>(3 * k).setConstant(value(shot.conditions));
    }
    return rows;
  }

  static std::string Range(const Eigen::VectorXd& x) {
    return Rounded("%.0f", x.minCoeff() * kDegree) + " to " + Rounded("%.0f", x.maxCoeff() * kDegree) + " deg";
  }

  double LogRows() const { return std::log(static_cast<double>(residual_.residual().size())); }

  double MarginalGain(const Eigen::MatrixXd& columns) const {
    Eigen::MatrixXd rest = residual_.ProjectOff(columns);
    const double scale = rest.norm();
    if (scale <= 1e-9 * columns.norm() || scale == 0.0) return -1e300;
    rest /= scale;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rest.transpose() * rest);
    const Eigen::VectorXd projected = eigen.eigenvectors().transpose() * (rest.transpose() * residual_.residual());
    double best = 0.0;
    for (double tau = 1.0; tau < 3e4; tau *= 2.0) {
      double gain = 0.0;
      for (int i = 0; i < projected.size(); ++i) {
        const double squared = eigen.eigenvalues()[i];
        if (squared < 1e-12) continue;
        const double t = tau * tau * squared;
        gain += projected[i] * projected[i] / squared * t / (1.0 + t) - std::log1p(t);
      }
      best = std::max(best, gain);
    }
    return best - LogRows() - 2.0 * std::log(families_);
  }

  // Penalised reductions of single columns side by side, `settings` scanned.
  Eigen::VectorXd SingleGains(const Eigen::MatrixXd& columns, int settings, Eigen::VectorXd* sizes) const {
    const Eigen::MatrixXd rest = residual_.ProjectOff(columns);
    const Eigen::ArrayXd squared = rest.colwise().squaredNorm().transpose().array().max(1e-300);
    const Eigen::ArrayXd projected = (rest.transpose() * residual_.residual()).array();
    *sizes = -(projected / squared).matrix();
    const Eigen::ArrayXd whole = columns.colwise().squaredNorm().transpose().array();
    const Eigen::ArrayXd told = (squared > 1e-6 * whole).cast<double>();
    return (told * projected.square() / squared - LogRows() - 2.0 * std::log(settings * families_)).matrix();
  }

  void Keep(Decoy decoy) {
    if (decoy.penalised > best_.penalised) best_ = std::move(decoy);
  }

  void TrySmooth(int j, const Eigen::VectorXd& x, std::vector<std::string> depends_on, const std::string& kind,
                 const std::string& on) {
    const double low = x.minCoeff(), high = x.maxCoeff();
    for (const int count : kSmoothBumps) {
      const double spacing = (high - low) / (count - 1);
      Eigen::MatrixXd columns(x.size(), count);
      for (int b = 0; b < count; ++b) {
        columns.col(b) =
            deviations_.col(j).array() * (-0.5 * ((x.array() - (low + b * spacing)) / spacing).square()).exp();
      }
      Decoy decoy{kind, depends_on, Name(j), "", MarginalGain(columns), columns};
      decoy.words = "a smooth deviation of " + Name(j) + " that depends on " + on;
      Keep(std::move(decoy));
    }
  }

  // One bump or one step along q_k.
  void TryPlaces(int j, int k) {
    const Eigen::ArrayXd& q = angles_[k].array();
    const double low = q.minCoeff(), span = q.maxCoeff() - low;
    constexpr int kWidths = sizeof(kBumpWidths) / sizeof(kBumpWidths[0]);
    Eigen::MatrixXd bumps(q.size(), kPlaces * kWidths), steps(q.size(), kPlaces);
    for (int p = 0; p < kPlaces; ++p) {
      const double place = low + span * (p + 0.5) / kPlaces;
      steps.col(p) = deviations_.col(j).array() * (q > place).cast<double>();
      for (int w = 0; w < kWidths; ++w) {
        bumps.col(p * kWidths + w) =
            deviations_.col(j).array() * (-0.5 * ((q - place) / (kBumpWidths[w] * span)).square()).exp();
      }
    }
    Eigen::VectorXd sizes;
    int at = 0;
    const double bump = SingleGains(bumps, kPlaces * kWidths, &sizes).maxCoeff(&at);
    if (bump > best_.penalised) {
      const double center = (low + span * (at / kWidths + 0.5) / kPlaces) * kDegree;
      const double reach = 1.5 * kBumpWidths[at % kWidths] * span * kDegree;
      Keep({"smooth",
            {Name(k)},
            Name(j),
            "a bump of " + Name(j) + " where " + Name(k) + " is between " + Rounded("%.0f", center - reach) + " and " +
                Rounded("%.0f", center + reach) + " deg, " + Rounded("%.3g", 1e-3 * sizes[at]) + " mrad high",
            bump,
            bumps.col(at)});
    }
    const double step = SingleGains(steps, kPlaces, &sizes).maxCoeff(&at);
    if (step > best_.penalised) {
      const double place = (low + span * (at + 0.5) / kPlaces) * kDegree;
      Keep({"step",
            {Name(k)},
            Name(j),
            "a step of " + Name(j) + " by " + Rounded("%.3g", 1e-3 * sizes[at]) + " mrad where " + Name(k) +
                " passes " + Rounded("%.0f", place) + " deg",
            step,
            steps.col(at)});
    }
  }

  // Joint j deviates with the angle of another joint.
  void TryHarmonics(int j, int k) {
    for (int order = 1; order <= kOrders; ++order) {
      Eigen::MatrixXd columns(angles_[k].size(), 2);
      columns << deviations_.col(j).cwiseProduct((order * angles_[k]).array().cos().matrix()),
          deviations_.col(j).cwiseProduct((order * angles_[k]).array().sin().matrix());
      const Score score = residual_.Test(columns, kOrders);
      const double penalised = score.rank > 0 ? score.penalised - 2.0 * std::log(families_) : -1e300;
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
    Keep({"other", {Name(a), Name(b)}, Name(j), words, MarginalGain(columns), columns});
    const Score product = residual_.Test(columns.col(0));
    const double penalised = product.rank > 0 ? product.penalised - 2.0 * std::log(families_) : -1e300;
    Keep({"other", {Name(a), Name(b)}, Name(j), words, penalised, columns.col(0)});
  }

  void TryWaves() {
    const double span = time_.maxCoeff() - time_.minCoeff();
    for (const std::string& station : problem_.data.stations) {
      const Eigen::MatrixXd shift = StationShift(station);
      Decoy best_wave{"time", {station}, station, "", -1e300, {}};
      for (int p = 1; p <= kPeriods; ++p) {
        const double omega = kTwoPi * (0.5 * p) / span;
        const Eigen::VectorXd c = (omega * time_).array().cos(), s = (omega * time_).array().sin();
        Eigen::MatrixXd columns(time_.size(), 6);
        columns << c.asDiagonal() * shift, s.asDiagonal() * shift;
        const double all = MarginalGain(columns) - 2.0 * std::log(static_cast<double>(kPeriods));
        TryWave(all, columns, omega, "", &best_wave);
        for (int axis = 0; axis < 3; ++axis) {
          Eigen::MatrixXd own(time_.size(), 2);
          own << columns.col(axis), columns.col(3 + axis);
          const Score score = residual_.Test(own, 3 * kPeriods);
          const double penalised = score.rank > 0 ? score.penalised - 2.0 * std::log(families_) : -1e300;
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

  // How a shift of the station's points in x, y, z moves the rows, whitened, per
  // um: the columns of its base position.
  Eigen::MatrixXd StationShift(const std::string& station) const {
    std::vector<int> columns;
    for (const char* axis : {"/x", "/y", "/z"}) columns.push_back(parameters_.FindCoordinate("base/" + station + axis));
    const std::vector<int> observations = problem_.CalibrationObservations();
    return 1e-6 *
           Linearize(problem_, parameters_, observations, columns, ObservationNoise(problem_, observations, 1e-3))
               .jacobian;
  }

  const CalibrationProblem& problem_;
  const ParameterSet& parameters_;
  ProjectedResidual residual_;
  Eigen::MatrixXd deviations_;
  std::vector<Eigen::VectorXd> angles_;
  Eigen::VectorXd time_;
  bool timed_ = false;
  double families_ = 1.0;
  Decoy best_;
};

}  // namespace

Decoy BestDecoy(const DiagnosedModel& model) { return Bench(model).Best(); }

}  // namespace sagitta
