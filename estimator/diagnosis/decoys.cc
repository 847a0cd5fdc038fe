#include "estimator/diagnosis/decoys.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "estimator/diagnosis/drivers.h"
#include "estimator/least_squares/linearization.h"

namespace sagitta {
namespace {

constexpr int kSmoothBumps[] = {6, 12, 24};  // over the range: what is smooth at one width is not at another
constexpr int kKindBumps = 24;
constexpr int kMostPlaces = 48;                                   // of a scanned bump or step
constexpr double kBumpWidths[] = {0.01, 0.02, 0.04, 0.08, 0.16};  // standard deviation over the range
constexpr int kOrders = 6;
constexpr int kPeriods = 100;  // half cycles over the data
constexpr double kTwoPi = 6.283185307179586;
constexpr double kDegreesPerRadian = 57.29577951308232;

std::string Rounded(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
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

// What functions of the shot can do through one whitened column: the sums over each shot's rows that the normal
// equations of column * f(shot) need, whatever f.
struct ShotSums {
  Eigen::VectorXd squared, gradient;
  Eigen::MatrixXd on_believed;  // believed basis x shots

  ShotSums(const Eigen::VectorXd& column, const std::vector<int>& shot_of_row, long shots,
           const ProjectedResidual& residual)
      : squared(Eigen::VectorXd::Zero(shots)),
        gradient(Eigen::VectorXd::Zero(shots)),
        on_believed(Eigen::MatrixXd::Zero(residual.basis().cols(), shots)) {
    for (long row = 0; row < column.size(); ++row) {
      const int s = shot_of_row[row];
      squared[s] += column[row] * column[row];
      gradient[s] += column[row] * residual.residual()[row];
      on_believed.col(s) += column[row] * residual.basis().row(row).transpose();
    }
  }

  NormalEquations Reduce(const Eigen::MatrixXd& functions) const {
    return ReduceOff(functions.transpose() * squared.asDiagonal() * functions, on_believed * functions,
                     functions.transpose() * gradient);
  }
};

// One search over all decoys on one residual.
class DecoySearch {
 public:
  DecoySearch(const DecoyBench& bench, const ProjectedResidual& residual)
      : problem_(bench.problem_),
        bench_(bench),
        residual_(residual),
        rows_(residual.residual().size()),
        angles_(bench.angles_),
        time_(bench.time_) {
    for (long j = 0; j < bench.deviations_.cols(); ++j) {
      sums_.emplace_back(bench.deviations_.col(j), bench.shot_of_row_, static_cast<long>(bench.shots_.size()),
                         residual);
    }
  }

  Decoy Best() {
    const int n = problem_.robot.num_joints();
    for (int k = 0; k < n; ++k) {
      if (!bench_.Moves(k)) continue;
      const std::string on = Name(k) + " (" + bench_.Range(k, angles_[k].minCoeff(), angles_[k].maxCoeff()) + ")";
      TrySmooth(angles_[k], {Name(k)}, "smooth", on);
      TryPlaces(k);
      if (bench_.Turns(k)) TryHarmonics(k);
    }
    for (int a = 0; a < n; ++a) {
      for (int b = a + 1; b < n; ++b) {
        if (bench_.Moves(a) && bench_.Moves(b)) TryProduct(a, b);
      }
    }
    if (bench_.timed_) {
      TrySmooth(time_, {}, "time", "time");
      TryWaves();
    }
    return best_;
  }

 private:
  const std::string& Name(int joint) const { return problem_.robot.chain.joints[joint].name; }
  int joints() const { return problem_.robot.num_joints(); }

  bool IsBetter(double penalised) const { return penalised > best_.penalised; }

  // Joint j deviates by functions of the shot.
  void Keep(const std::string& kind, std::vector<std::string> depends_on, int j, const std::string& words,
            double penalised, const Eigen::MatrixXd& functions) {
    best_ = {kind,      std::move(depends_on),
             Name(j),   words,
             penalised, bench_.deviations_.col(j).asDiagonal() * bench_.OnRows(functions)};
  }

  // Any joint deviates by a smooth function of x.
  void TrySmooth(const Eigen::VectorXd& x, const std::vector<std::string>& depends_on, const std::string& kind,
                 const std::string& on) {
    const double scanned = 2.0 * std::log(joints() * (sizeof(kSmoothBumps) / sizeof(kSmoothBumps[0])));
    for (const int count : kSmoothBumps) {
      const Eigen::MatrixXd bumps = Bumps(x, count);
      for (int j = 0; j < joints(); ++j) {
        const double penalised = MarginalGainOf(sums_[j].Reduce(bumps), rows_) - scanned;
        if (!IsBetter(penalised)) continue;
        Keep(kind, depends_on.empty() ? std::vector<std::string>{Name(j)} : depends_on, j,
             "a smooth deviation of " + Name(j) + " that depends on " + on, penalised, bumps);
      }
    }
  }

  // Penalised reductions of joint j deviating by each single function, `settings` scanned.
  Eigen::VectorXd SingleGains(int j, const Eigen::MatrixXd& functions, int settings, Eigen::VectorXd* sizes) const {
    const ShotSums& sums = sums_[j];
    const Eigen::ArrayXd whole = (functions.array().square().matrix().transpose() * sums.squared).array();
    const Eigen::ArrayXd on_believed = (sums.on_believed * functions).colwise().squaredNorm().transpose().array();
    const Eigen::ArrayXd squared = (whole - on_believed).max(1e-300);
    const Eigen::ArrayXd projected = (functions.transpose() * sums.gradient).array();
    *sizes = -(projected / squared).matrix();
    const Eigen::ArrayXd told = (squared > 1e-6 * whole).cast<double>();
    const double n = static_cast<double>(rows_);
    return (told * projected.square() / squared - std::log(n) - 2.0 * std::log(settings)).matrix();
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
      if (p + 1 < count) steps.col(p) = (q > 0.5 * (places[p] + places[p + 1])).cast<double>();
      for (int w = 0; w < kWidths; ++w) {
        bumps.col(p * kWidths + w) = (-0.5 * ((q - places[p]) / (kBumpWidths[w] * span)).square()).exp();
      }
    }
    Eigen::VectorXd sizes;
    int at = 0;
    const double bump = SingleGains(j, bumps, static_cast<int>(bumps.cols()), &sizes).maxCoeff(&at);
    if (IsBetter(bump)) {
      const double center = places[at / kWidths], reach = 1.5 * kBumpWidths[at % kWidths] * span;
      const std::string words = "a bump of " + Name(j) + " between " + bench_.Place(j, center - reach) + " and " +
                                bench_.Place(j, center + reach) + bench_.PlaceUnit(j) + ", " +
                                Size(j, residual_.noise() * sizes[at]) + " high";
      Keep("smooth", {Name(j)}, j, words, bump, bumps.col(at));
    }
    if (count < 2) return;
    const double step = SingleGains(j, steps, count - 1, &sizes).maxCoeff(&at);
    if (!IsBetter(step)) return;
    const double place = 0.5 * (places[at] + places[at + 1]);
    const std::string words = "a step of " + Name(j) + " by " + Size(j, residual_.noise() * sizes[at]) + " at " +
                              bench_.Place(j, place) + bench_.PlaceUnit(j);
    Keep("step", {Name(j)}, j, words, step, steps.col(at));
  }

  // Of a deviation in urad, or um.
  std::string Size(int j, double value) const {
    return Rounded("%.3g", 1e-3 * value) + (bench_.Turns(j) ? " mrad" : " mm");
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

  // A score test; no gain where nothing of it shows.
  double Gain(const NormalEquations& normal, int settings) const {
    const Score score = ScoreOf(normal, rows_, settings);
    return score.rank > 0 ? score.penalised : -1e300;
  }

  // Other joints deviate with the angle of joint k.
  void TryHarmonics(int k) {
    for (int order = 1; order <= kOrders; ++order) {
      Eigen::MatrixXd wave(angles_[k].size(), 2);
      wave << (order * angles_[k]).array().cos().matrix(), (order * angles_[k]).array().sin().matrix();
      for (int j = 0; j < joints(); ++j) {
        if (j == k) continue;
        const double penalised = Gain(sums_[j].Reduce(wave), kOrders * (joints() - 1));
        if (!IsBetter(penalised)) continue;
        Keep("periodic", {Name(k)}, j,
             "a deviation of " + Name(j) + " that repeats " + std::to_string(order) + " time(s) per turn of " + Name(k),
             penalised, wave);
      }
    }
  }

  // Any joint deviates with two joints' angles together.
  void TryProduct(int a, int b) {
    const Eigen::ArrayXd p = angles_[a].array() - angles_[a].dot(bench_.weight_);
    const Eigen::ArrayXd q = angles_[b].array() - angles_[b].dot(bench_.weight_);
    const Eigen::ArrayXd sum = angles_[a].array() + angles_[b].array();
    const Eigen::ArrayXd difference = angles_[a].array() - angles_[b].array();
    Eigen::MatrixXd basis(p.size(), 7);
    basis << (p * q).matrix(), sum.cos().matrix(), sum.sin().matrix(), difference.cos().matrix(),
        difference.sin().matrix(), (p.cos() * q).matrix(), (q.cos() * p).matrix();
    const int pairs = joints() * (joints() - 1) / 2;
    for (int j = 0; j < joints(); ++j) {
      const std::string words =
          "a deviation of " + Name(j) + " that depends on " + Name(a) + " and " + Name(b) + " together";
      const NormalEquations normal = sums_[j].Reduce(basis);
      const double any = MarginalGainOf(normal, rows_) - 2.0 * std::log(2.0 * pairs);
      if (IsBetter(any)) Keep("other", {Name(a), Name(b)}, j, words, any, basis);
      const double product = Gain({normal.information.topLeftCorner(1, 1), normal.gradient.head(1)}, 2 * pairs);
      if (IsBetter(product)) Keep("other", {Name(a), Name(b)}, j, words, product, basis.col(0));
    }
  }

  void TryWaves() {
    const double span = time_.maxCoeff() - time_.minCoeff();
    const Eigen::VectorXd time = bench_.OnRows(time_);
    for (const auto& [station, shift] : bench_.shifts_) {
      Decoy best_wave{"time", {station}, station, "", -1e300, {}, true};
      for (int p = 1; p <= kPeriods; ++p) {
        const double omega = kTwoPi * (0.5 * p) / span;
        const Eigen::VectorXd c = (omega * time).array().cos(), s = (omega * time).array().sin();
        Eigen::MatrixXd columns(time.size(), 6);
        columns << c.asDiagonal() * shift, s.asDiagonal() * shift;
        const NormalEquations normal = residual_.Reduce(columns);
        TryWave(MarginalGainOf(normal, rows_) - 2.0 * std::log(4.0 * kPeriods), columns, omega, "", &best_wave);
        for (int axis = 0; axis < 3; ++axis) {
          const std::vector<int> own = {axis, 3 + axis};
          const double gain = Gain({normal.information(own, own), normal.gradient(own)}, 4 * kPeriods);
          TryWave(gain, columns(Eigen::all, own), omega, std::string(" in ") + "xyz"[axis], &best_wave);
        }
      }
      if (IsBetter(best_wave.penalised)) best_ = std::move(best_wave);
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
  const long rows_;
  const std::vector<Eigen::VectorXd>& angles_;
  const Eigen::VectorXd& time_;
  std::vector<ShotSums> sums_;  // of each joint's deviation
  Decoy best_;
};

DecoyBench::DecoyBench(const DiagnosedModel& model)
    : problem_(*model.problem),
      parameters_(model.estimate.parameters),
      residual_(LinearizeEstimate(problem_, parameters_)),
      dof_(model.estimate.dof),
      deviations_(JointDeviationColumns(problem_, parameters_)) {
  std::map<int, int> place;
  for (const int observation : problem_.CalibrationObservations()) {
    const int shot = problem_.data.observations[observation].shot;
    const auto entry = place.emplace(shot, static_cast<int>(shots_.size()));
    if (entry.second) shots_.push_back(shot);
    shot_of_row_.insert(shot_of_row_.end(), 3, entry.first->second);
  }
  weight_ = Eigen::VectorXd::Zero(static_cast<long>(shots_.size()));
  for (const int shot : shot_of_row_) weight_[shot] += 1.0 / static_cast<double>(shot_of_row_.size());
  const int n = problem_.robot.num_joints();
  for (int j = 0; j < n; ++j) angles_.push_back(PerShot([j](const ShotConditions& shot) { return shot.q[j]; }));
  timed_ = std::all_of(problem_.shot_inputs.begin(), problem_.shot_inputs.end(),
                       [](const ShotInput& shot) { return shot.conditions.has_time; });
  if (timed_) time_ = PerShot([](const ShotConditions& shot) { return shot.time; });
  timed_ = timed_ && time_.maxCoeff() > time_.minCoeff();
  if (!timed_) return;
  for (const std::string& station : problem_.data.stations) shifts_[station] = StationShift(station);
}

bool DecoyBench::Moves(int joint) const { return angles_[joint].maxCoeff() - angles_[joint].minCoeff() >= 1e-6; }

bool DecoyBench::Turns(int joint) const { return sagitta::Turns(problem_, joint); }

std::string DecoyBench::Place(int joint, double value) const {
  return Rounded("%.0f", value * (Turns(joint) ? kDegreesPerRadian : 1e3));
}

std::string DecoyBench::Range(int joint, double low, double high) const {
  return Place(joint, low) + " to " + Place(joint, high) + PlaceUnit(joint);
}

Decoy DecoyBench::Best(const ProjectedResidual& residual) const { return DecoySearch(*this, residual).Best(); }

Decoy DecoyBench::BestInScatter() const {
  Decoy best = Best();
  const int dof = dof_ - static_cast<int>(best.columns.cols());
  if (best.columns.cols() == 0 || dof <= 0) return best;
  const double left = residual_.With(best.columns).residual().squaredNorm() / dof;
  return left > 1.0 ? Best(residual_.InNoise(std::sqrt(left))) : best;
}

Eigen::MatrixXd DecoyBench::ColumnsOfKind(const Decoy& decoy) const {
  if (decoy.columns.cols() == 0) return Eigen::MatrixXd(residual_.residual().size(), 0);  // nothing moves
  std::vector<Eigen::MatrixXd> blocks = {decoy.columns};
  const int j = problem_.robot.chain.FindJoint(decoy.acts_on);
  if (decoy.moves_station) {
    const Eigen::MatrixXd bumps = OnRows(Bumps(time_, kKindBumps));
    for (int b = 0; b < kKindBumps; ++b) blocks.push_back(bumps.col(b).asDiagonal() * shifts_.at(decoy.acts_on));
  } else if (decoy.kind == "time") {
    blocks.push_back(deviations_.col(j).asDiagonal() * OnRows(Bumps(time_, kKindBumps)));
  } else {
    for (const std::string& driver : decoy.depends_on) {
      const int k = problem_.robot.chain.FindJoint(driver);
      if (!Moves(k)) continue;
      blocks.push_back(deviations_.col(j).asDiagonal() * OnRows(Bumps(angles_[k], kKindBumps)));
    }
  }
  Eigen::MatrixXd all(decoy.columns.rows(), 0);
  for (const Eigen::MatrixXd& block : blocks) {
    all.conservativeResize(Eigen::NoChange, all.cols() + block.cols());
    all.rightCols(block.cols()) = block;
  }
  return all;
}

Eigen::VectorXd DecoyBench::PerShot(const std::function<double(const ShotConditions&)>& value) const {
  Eigen::VectorXd values(shots_.size());
  for (size_t s = 0; s < shots_.size(); ++s) values[s] = value(problem_.shot_inputs[shots_[s]].conditions);
  return values;
}

// How a shift of the station's points in x, y, z moves the rows, whitened, per
// um: the columns of its base position.
Eigen::MatrixXd DecoyBench::StationShift(const std::string& station) const {
  std::vector<int> columns;
  for (const char* axis : {"/x", "/y", "/z"}) columns.push_back(parameters_.FindCoordinate("base/" + station + axis));
  const std::vector<int> observations = problem_.CalibrationObservations();
  return 1e-6 * Linearize(problem_, parameters_, observations, columns,
                          ObservationNoise(problem_, observations, kFallbackSigma))
                    .jacobian;
}

}  // namespace sagitta
