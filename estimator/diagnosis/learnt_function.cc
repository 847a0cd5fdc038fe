#include "estimator/diagnosis/learnt_function.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "estimator/explanations/driver_functions.h"
#include "estimator/explanations/drivers.h"
#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kTableRows = 41;    // four to each of ten bumps; both ends and the middle among them
constexpr int kOrders = 12;          // what ten bumps over a turn can follow, and a little more
constexpr double kLeastBand = 1e-9;  // urad or um: a value that is known exactly has a finite weight
// Times that a formula fades in: from about a row of the table, which one value would show, up to its span; the nearest
// is off by a seventh at most. Its dead band is tried in as many parts of the range as a third of the rows.
constexpr double kFastestFading = 1.0 / 32.0, kNextFading = 1.3;
constexpr int kDeadbandParts = 16;

std::string Rounded(double value) { return Significant(value, 3); }

// The unnamed member that the set can least do without; else the best to add in the first view, if it stands out. -1:
// none.
int StrongestFunction(const Evidence& evidence, const WeightedModel& model, WeightedModel* with) {
  const ExplanationList& list = evidence.list();
  *with = model;
  const std::vector<double> losses = evidence.SearchIn(model.view).LossesOf(model.set);
  int strongest = -1;
  double most = -std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < losses.size(); ++k) {
    if (!list.IsUnnamed(model.set.members[k]) || losses[k] <= most) continue;
    most = losses[k];
    strongest = model.set.members[k];
  }
  if (strongest >= 0) return strongest;
  with->view = 0;
  const SetSearch search = evidence.SearchIn(0);
  const WeightedSet base = search.Evaluate(model.set.members, model.set.scales);
  const std::vector<double> weights = search.Additions(base);
  most = base.log_weight + kStandsOut;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (!list.IsUnnamed(static_cast<int>(k)) || weights[k] <= most) continue;
    most = weights[k];
    strongest = static_cast<int>(k);
  }
  if (strongest < 0) return -1;
  with->set = search.Evaluate(EachOnce(model.set.members, {strongest}));
  return strongest;
}

struct Formula {
  std::string words, formula;
  double explained = 0.0;
};

// Offered in the order of simplicity: a later one has to explain half of what the one before leaves.
class FormulaSearch {
 public:
  // x_name: of the driver, in formulas.
  FormulaSearch(const LearntFunction& learnt, const std::string& x_name)
      : driver_(learnt.what.driver.name),
        x_name_(x_name),
        unit_(learnt.what.driver.unit),
        of_(learnt.unit),
        kind_(learnt.what.driver.kind) {
    const long n = static_cast<long>(learnt.table.size());
    x_.resize(n);
    y_.resize(n);
    weights_.resize(n);
    for (long i = 0; i < n; ++i) {
      const FunctionPoint& point = learnt.table[i];
      x_[i] = point.at;
      y_[i] = point.value;
      weights_[i] = 1.0 / std::max(kLeastBand, point.sigma);
    }
  }

  Formula Nearest() {
    TryLine();
    TryJump();
    if (kind_ == DriverKind::kAngle) TryHarmonics();
    if (kind_ == DriverKind::kTime) TryExponential();
    TryDeadband();
    if (!best_.words.empty()) best_.words += " (" + Rounded(100.0 * best_.explained) + " % of it)";
    return best_;
  }

 private:
  // One of a family of formulas: a constant and these functions of the driver, fitted.
  struct Fitted {
    double explained = 0.0;  // share of the weighted square
    double setting = 0.0;
    Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(2);
  };

  // functions: of x, with their coefficients in `fitted`.
  void Offer(const Fitted& fitted, const std::string& words, const std::vector<std::string>& functions) {
    const double explained = fitted.explained;
    if (best_.words.empty() ? explained > 0.5 : 1.0 - explained < 0.5 * (1.0 - best_.explained)) {
      best_ = {words, Sum(fitted, functions), explained};
    }
  }

  // The constant is the last coefficient.
  static std::string Sum(const Fitted& fitted, const std::vector<std::string>& functions) {
    std::string sum;
    for (size_t k = 0; k <= functions.size(); ++k) {
      const double value = fitted.coefficients[static_cast<long>(k)];
      sum += sum.empty() ? (value < 0.0 ? "-" : "") : (value < 0.0 ? " - " : " + ");
      sum += Significant(std::abs(value), 4) + (k < functions.size() ? "·" + functions[k] : "");
    }
    return sum;
  }

  // R^2 = 1 - sum w^2 (y - X c)^2 / sum w^2 (y - mean)^2, w = 1 / sigma.
  Fitted Fit(const Eigen::MatrixXd& functions, double setting = 0.0) const {
    Eigen::MatrixXd columns(functions.rows(), functions.cols() + 1);
    columns << functions, Eigen::VectorXd::Ones(functions.rows());
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(weights_.asDiagonal() * columns);
    const Eigen::VectorXd c = qr.solve(weights_.cwiseProduct(y_));
    const double mean = weights_.cwiseAbs2().dot(y_) / weights_.squaredNorm();
    const double all = (weights_.array() * (y_.array() - mean)).matrix().squaredNorm();
    return {all > 0.0 ? 1.0 - weights_.cwiseProduct(y_ - columns * c).squaredNorm() / all : 0.0, setting, c};
  }

  // The best of functions(setting).
  template <typename Functions>
  Fitted Best(const std::vector<double>& settings, const Functions& functions) const {
    Fitted best;
    for (const double setting : settings) {
      const Fitted here = Fit(functions(setting), setting);
      if (here.explained > best.explained) best = here;
    }
    return best;
  }

  void TryLine() {
    const Fitted line = Fit(x_);
    Offer(line, "proportional to " + driver_ + ": " + Size(line) + " per " + unit_, {x_name_});
  }

  void TryJump() {
    std::vector<double> places;
    for (long i = 1; i < x_.size(); ++i) places.push_back(0.5 * (x_[i - 1] + x_[i]));
    const Fitted jump =
        Best(places, [&](double at) -> Eigen::MatrixXd { return (x_.array() > at).cast<double>().matrix(); });
    Offer(jump, "a jump of " + Size(jump) + " at " + driver_ + " = " + Rounded(jump.setting) + " " + unit_,
          {"(" + x_name_ + " > " + Significant(jump.setting, 4) + ")"});
  }

  void TryHarmonics() {
    std::vector<double> orders(kOrders);
    std::iota(orders.begin(), orders.end(), 1.0);
    const Fitted wave = Best(orders, [&](double n) { return Wave(n * kDegree * x_); });
    const double size = wave.coefficients.head<2>().norm();
    const int order = static_cast<int>(wave.setting);
    const std::string angle = "(" + std::to_string(order) + "·" + x_name_ + ")";
    Offer(wave, WaveInWords(Rounded(size) + " " + of_, order, driver_), {"cos" + angle, "sin" + angle});
  }

  void TryExponential() {
    const double first = x_.minCoeff(), span = x_.maxCoeff() - first;
    std::vector<double> times;
    for (double t = kFastestFading * span; t <= span; t *= kNextFading) times.push_back(t);
    const Fitted fading =
        Best(times, [&](double t) -> Eigen::MatrixXd { return (-(x_.array() - first) / t).exp().matrix(); });
    const std::string since = "-(" + x_name_ + " - " + Significant(first, 4) + ")/" + Significant(fading.setting, 4);
    Offer(fading, ExponentialInWords(Size(fading), Rounded(fading.setting) + " s"), {"exp(" + since + ")"});
  }

  void TryDeadband() {
    std::vector<double> halves;
    for (int i = 1; i < kDeadbandParts; ++i) halves.push_back(x_.cwiseAbs().maxCoeff() * i / kDeadbandParts);
    const Fitted beyond = Best(halves, [&](double half) -> Eigen::MatrixXd {
      return (x_.array().sign() * (x_.array().abs() - half).max(0.0)).matrix();
    });
    const std::string half = Significant(beyond.setting, 4);
    Offer(beyond, DeadbandInWords(Rounded(beyond.setting) + " " + unit_, driver_, Size(beyond) + " per " + unit_),
          {"sign(" + x_name_ + ")·max(0, |" + x_name_ + "| - " + half + ")"});
  }

  std::string Size(const Fitted& fitted) const { return Rounded(fitted.coefficients[0]) + " " + of_; }

  std::string driver_, x_name_, unit_, of_;
  DriverKind kind_;
  Eigen::VectorXd x_, y_, weights_;
  Formula best_;
};

// What a source does, over one driver, by all members of a set that have no name and follow that driver: pieces may
// cancel most of each other. Of each its columns of that source,  f(shot) = sum (columns - their mean) mixing c,  and
// the posterior of all their coefficients c, in typical sizes.
class DeviationOfSource {
 public:
  DeviationOfSource(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& problem,
                    const Driver& driver, const Source& source)
      : shots_(FittedShots(problem)), of_shot_(driver.of_shot) {
    const ExplanationList& list = evidence.list();
    const std::vector<const ColumnGroup*> groups = GroupsOf(list.math, model.set.members);
    const GroupValues all = ValuesOf(evidence.NormalOf(model.view), groups, model.set.scales);
    std::vector<long> places;  // of the coefficients
    columns_.resize(of_shot_.size(), 0);
    long first = 0;
    for (size_t k = 0; k < groups.size(); first += groups[k]->size(), ++k) {
      const int member = model.set.members[k];
      const bool is_nameless = list.IsUnnamed(member) || model.HasPiece(member);
      if (!is_nameless || !IsOver(driver, list, member, problem)) continue;
      const Eigen::MatrixXd own = FunctionsOf(evidence.columns(), *groups[k], source);
      if (own.cols() == 0) continue;
      columns_.conservativeResize(Eigen::NoChange, columns_.cols() + own.cols());
      columns_.rightCols(own.cols()) = own;
      for (long c = 0; c < own.cols(); ++c) places.push_back(first + c);
    }
    values_ = all.values(places);
    covariance_ = all.covariance(places, places);
    columns_.rowwise() -= columns_(shots_, Eigen::all).colwise().mean().eval();
  }

  double Square() const { return (columns_(shots_, Eigen::all) * values_).squaredNorm(); }

  // Its values and their standard deviations times `unit`, at kTableRows of the driver's values, ascending.
  std::vector<FunctionPoint> Table(double unit) const {
    std::vector<int> shots = shots_;
    std::sort(shots.begin(), shots.end(), [&](int a, int b) { return of_shot_[a] < of_shot_[b]; });
    const auto equal = [&](int a, int b) { return of_shot_[a] == of_shot_[b]; };
    shots.erase(std::unique(shots.begin(), shots.end(), equal), shots.end());
    const size_t rows = std::min(kTableRows, shots.size());
    std::vector<FunctionPoint> table;
    for (size_t r = 0; r < rows; ++r) {
      const int shot = shots[rows > 1 ? r * (shots.size() - 1) / (rows - 1) : 0];
      const Eigen::VectorXd row = columns_.row(shot).transpose();
      table.push_back(
          {of_shot_[shot], unit * row.dot(values_), unit * std::sqrt(std::max(0.0, row.dot(covariance_ * row)))});
    }
    return table;
  }

 private:
  static bool IsOver(const Driver& driver, const ExplanationList& list, int member, const CalibrationProblem& problem) {
    const Driver own =
        list.IsUnnamed(member) ? list.functions[list.unnamed[member]].driver : DriverOf(problem, list.SpecOf(member));
    return own.of_shot.size() == driver.of_shot.size() && own.of_shot == driver.of_shot;
  }

  // One column per coefficient; none where the group moves the source in no way.
  static Eigen::MatrixXd FunctionsOf(const EvidenceColumns& columns, const ColumnGroup& group, const Source& source) {
    std::vector<int> own;
    std::vector<long> rows;  // of the mixing
    for (size_t c = 0; c < group.columns.size(); ++c) {
      const std::optional<Source> moved = columns.MotionOf(group.columns[c]);
      if (!moved || !(*moved == source)) continue;
      own.push_back(group.columns[c]);
      rows.push_back(static_cast<long>(c));
    }
    if (own.empty()) return {};
    const Eigen::MatrixXd mixing =
        group.mixing.size() > 0
            ? group.mixing
            : Eigen::MatrixXd::Identity(group.size(), static_cast<long>(group.columns.size())).eval();
    return columns.FunctionOf(own) * mixing(rows, Eigen::all);
  }

  std::vector<int> shots_;  // fitted
  Eigen::VectorXd of_shot_;
  Eigen::MatrixXd columns_;  // shots x coefficients
  Eigen::VectorXd values_;
  Eigen::MatrixXd covariance_;
};

// Of those that the function moves, the one that moves most.
std::pair<Source, DeviationOfSource> StrongestOf(const std::vector<Source>& sources, const Evidence& evidence,
                                                 const WeightedModel& model, const CalibrationProblem& problem,
                                                 const Driver& driver) {
  std::vector<DeviationOfSource> deviations;
  for (const Source& source : sources) deviations.emplace_back(evidence, model, problem, driver, source);
  const auto is_less = [](const auto& a, const auto& b) { return a.Square() < b.Square(); };
  const auto strongest = std::max_element(deviations.begin(), deviations.end(), is_less);
  return {sources[static_cast<size_t>(strongest - deviations.begin())], *strongest};
}

}  // namespace

LearntFunction LearnFunction(const Evidence& evidence, const Posterior& posterior, const WeightedModel& model,
                             const CalibrationProblem& problem) {
  LearntFunction learnt;
  learnt.what.kind = "other";
  WeightedModel with;
  const int member = StrongestFunction(evidence, model, &with);
  if (member < 0) return learnt;
  learnt.what = evidence.list().functions[evidence.list().unnamed[member]];
  learnt.probability = posterior.Of(evidence.list().name[member]);
  for (const int m : model.pieces) learnt.pieces.push_back(evidence.list().SpecOf(m));
  const Driver& driver = learnt.what.driver;
  if (driver.of_shot.size() == 0) return learnt;
  const auto [source, deviation] = StrongestOf(learnt.what.sources, evidence, with, problem, driver);
  const SourceUnit in = UnitOf(source, problem.robot().chain);
  learnt.unit = in.micro;
  learnt.table = deviation.Table(in.typical / kMicro);
  const int joint = problem.robot().chain.FindJoint(driver.name);
  const bool is_joint_value = driver.kind == DriverKind::kAngle || driver.kind == DriverKind::kTravel;
  const std::string joint_value = is_joint_value && joint >= 0 ? "q" + std::to_string(joint + 1) : "";
  learnt.driver = joint_value.empty() ? driver.name : joint_value;
  const Formula nearest = FormulaSearch(learnt, joint_value.empty() ? "x" : joint_value).Nearest();
  learnt.formula = nearest.formula;
  learnt.words = nearest.words;
  return learnt;
}

}  // namespace sagitta
