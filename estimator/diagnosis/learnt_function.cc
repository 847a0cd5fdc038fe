#include "estimator/diagnosis/learnt_function.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "estimator/report/explanations_words.h"
#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

constexpr size_t kTableRows = 41;
constexpr int kOrders = 12;  // what ten bumps over a turn can follow, and a little more

std::string Rounded(double value) { return Significant(value, 3); }

// The unnamed member that the set can least do without; else the best to add in the first view, if it stands out. -1:
// none.
int StrongestFunction(const Evidence& evidence, const WeightedModel& model, WeightedModel* with) {
  const ExplanationList& list = evidence.list();
  *with = model;
  const SetSearch own = evidence.SearchIn(model.view);
  int strongest = -1;
  double most = -std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < model.set.members.size(); ++k) {
    if (!list.IsUnnamed(model.set.members[k])) continue;
    std::vector<int> others = model.set.members;
    others.erase(others.begin() + static_cast<long>(k));
    const double loss = -own.Evaluate(others).log_weight;
    if (loss <= most) continue;
    most = loss;
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
  std::vector<int> members = model.set.members;
  members.insert(std::lower_bound(members.begin(), members.end(), strongest), strongest);
  with->set = search.Evaluate(members);
  return strongest;
}

// R^2 = 1 - sum w^2 (y - X c)^2 / sum w^2 (y - mean)^2, w = 1 / sigma.
// Weighted least squares; the share of the square that it explains.
double Explained(const Eigen::MatrixXd& functions, const Eigen::VectorXd& values, const Eigen::VectorXd& weights,
                 Eigen::VectorXd* coefficients) {
  Eigen::MatrixXd columns(functions.rows(), functions.cols() + 1);
  columns << functions, Eigen::VectorXd::Ones(functions.rows());
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(weights.asDiagonal() * columns);
  const Eigen::VectorXd weighted = weights.cwiseProduct(values);
  *coefficients = qr.solve(weighted);
  const double mean = weights.cwiseAbs2().dot(values) / weights.squaredNorm();
  const double all = (weights.array() * (values.array() - mean)).matrix().squaredNorm();
  return all > 0.0 ? 1.0 - weights.cwiseProduct(values - columns * *coefficients).squaredNorm() / all : 0.0;
}

struct Formula {
  std::string words;
  double explained = 0.0;
};

// Offered in the order of simplicity: a later one has to explain half of what the one before leaves.
class FormulaSearch {
 public:
  FormulaSearch(const LearntFunction& learnt)
      : driver_(learnt.driver), unit_(learnt.driver_unit), of_(learnt.unit), kind_(learnt.driver_kind) {
    const long n = static_cast<long>(learnt.table.size());
    x_.resize(n);
    y_.resize(n);
    weights_.resize(n);
    for (long i = 0; i < n; ++i) {
      const FunctionPoint& point = learnt.table[static_cast<size_t>(i)];
      x_[i] = point.at;
      y_[i] = point.value;
      weights_[i] = 1.0 / std::max(1e-9, point.sigma);
    }
  }

  std::string Nearest() {
    TryLine();
    TryJump();
    if (kind_ == DriverKind::kAngle) TryHarmonics();
    if (kind_ == DriverKind::kTime) TryExponential();
    TryDeadband();
    if (best_.words.empty()) return "";
    return best_.words + " (" + Rounded(100.0 * best_.explained) + " % of it)";
  }

 private:
  void Offer(double explained, const std::string& words) {
    if (best_.words.empty() ? explained > 0.5 : 1.0 - explained < 0.5 * (1.0 - best_.explained)) {
      best_ = {words, explained};
    }
  }

  void TryLine() {
    const double explained = Explained(x_, y_, weights_, &c_);
    Offer(explained, "proportional to " + driver_ + ": " + Rounded(c_[0]) + " " + of_ + " per " + unit_);
  }

  void TryJump() {
    double most = 0.0, size = 0.0, place = 0.0;
    for (long i = 1; i < x_.size(); ++i) {
      const double here = 0.5 * (x_[i - 1] + x_[i]);
      const double explained = Explained((x_.array() > here).cast<double>().matrix(), y_, weights_, &c_);
      if (explained <= most) continue;
      most = explained;
      size = c_[0];
      place = here;
    }
    Offer(most, "a jump of " + Rounded(size) + " " + of_ + " at " + driver_ + " = " + Rounded(place) + " " + unit_);
  }

  void TryHarmonics() {
    double most = 0.0, size = 0.0;
    int order = 0;
    for (int n = 1; n <= kOrders; ++n) {
      Eigen::MatrixXd waves(x_.size(), 2);
      waves << (n * kDegree * x_.array()).cos().matrix(), (n * kDegree * x_.array()).sin().matrix();
      const double explained = Explained(waves, y_, weights_, &c_);
      if (explained <= most) continue;
      most = explained;
      size = std::hypot(c_[0], c_[1]);
      order = n;
    }
    Offer(most, WaveInWords(Rounded(size) + " " + of_, order, driver_));
  }

  void TryExponential() {
    const double first = x_.minCoeff(), span = x_.maxCoeff() - first;
    double most = 0.0, size = 0.0, tau = 0.0;
    for (double t = span / 32.0; t <= span; t *= 1.3) {
      const double explained = Explained((-(x_.array() - first) / t).exp().matrix(), y_, weights_, &c_);
      if (explained <= most) continue;
      most = explained;
      size = c_[0];
      tau = t;
    }
    Offer(most, ExponentialInWords(Rounded(size) + " " + of_, Rounded(tau) + " s"));
  }

  void TryDeadband() {
    const double reach = x_.cwiseAbs().maxCoeff();
    double most = 0.0, slope = 0.0, width = 0.0;
    for (int i = 1; i < 16; ++i) {
      const double half = reach * i / 16.0;
      const Eigen::ArrayXd beyond = x_.array().sign() * (x_.array().abs() - half).max(0.0);
      const double explained = Explained(beyond.matrix(), y_, weights_, &c_);
      if (explained <= most) continue;
      most = explained;
      slope = c_[0];
      width = half;
    }
    Offer(most, DeadbandInWords(Rounded(width) + " " + unit_, driver_, Rounded(slope) + " " + of_ + " per " + unit_));
  }

  std::string driver_, unit_, of_;
  DriverKind kind_;
  Eigen::VectorXd x_, y_, weights_, c_;
  Formula best_;
};

}  // namespace

LearntFunction LearnFunction(const Evidence& evidence, const WeightedModel& model, const CalibrationProblem& problem) {
  LearntFunction learnt;
  WeightedModel with;
  const int member = StrongestFunction(evidence, model, &with);
  if (member < 0) return learnt;
  const UnnamedFunction& what = evidence.list().functions[evidence.list().unnamed[member]];
  learnt.kind = what.kind;
  learnt.acts_on = what.acts_on;
  learnt.depends_on = what.depends_on;
  learnt.words = what.words;
  for (const int m : model.pieces) learnt.pieces.push_back(evidence.list().SpecOf(m));
  if (what.driver.of_shot.size() == 0) return learnt;
  learnt.driver = what.driver.name;
  learnt.driver_unit = what.driver.unit;
  learnt.driver_kind = what.driver.kind;

  const ColumnGroup& group = evidence.list().math[member].group;
  const GroupValues own_values = evidence.ValuesOfMember(with, member);
  const Eigen::MatrixXd& covariance = own_values.covariance;
  const Eigen::VectorXd& coefficients = own_values.values;
  // Of several axes, the one that moves most.
  const long height = static_cast<long>(group.columns.size() / what.sources.size());
  long best = 0;
  double most = -1.0;
  const std::vector<int> own(group.columns.begin(), group.columns.begin() + height);
  const Eigen::MatrixXd functions = evidence.columns().FunctionOf(own);
  std::vector<int> shots = FittedShots(problem);
  const Eigen::MatrixXd seen = functions(shots, Eigen::all);
  const Eigen::RowVectorXd mean = seen.colwise().mean();
  for (long s = 0; s < static_cast<long>(what.sources.size()); ++s) {
    const double size =
        ((seen.rowwise() - mean) * group.mixing.middleRows(s * height, height) * coefficients).squaredNorm();
    if (size <= most) continue;
    most = size;
    best = s;
  }
  const Source& source = what.sources[static_cast<size_t>(best)];
  const double typical = TypicalSizeOf(source, problem.robot().chain);
  learnt.unit = UnitOf(source, problem.robot().chain);
  std::sort(shots.begin(), shots.end(), [&](int a, int b) { return what.driver.of_shot[a] < what.driver.of_shot[b]; });
  const auto equal = [&](int a, int b) { return what.driver.of_shot[a] == what.driver.of_shot[b]; };
  shots.erase(std::unique(shots.begin(), shots.end(), equal), shots.end());
  const size_t rows = std::min(kTableRows, shots.size());
  for (size_t r = 0; r < rows; ++r) {
    const int shot = shots[rows > 1 ? r * (shots.size() - 1) / (rows - 1) : 0];
    const Eigen::VectorXd row =
        ((functions.row(shot) - mean) * group.mixing.middleRows(best * height, height)).transpose();
    const double unit = typical / kMicro;
    learnt.table.push_back({what.driver.of_shot[shot], unit * row.dot(coefficients),
                            unit * std::sqrt(std::max(0.0, row.dot(covariance * row)))});
  }
  learnt.formula = FormulaSearch(learnt).Nearest();
  return learnt;
}

}  // namespace sagitta
