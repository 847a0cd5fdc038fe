// The evidence of groups of columns against the marginal likelihood written out: determinant and inverse of the whole
// covariance, integrals over what is not known by quadrature, sets by enumeration.
#include "estimator/evidence/evidence.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "estimator/evidence/nameless_cause.h"
#include "estimator/random_effects/evidence_score.h"
#include "estimator/random_effects/set_search.h"
#include "estimator/random_effects/sweep.h"
#include "tests/support/small_evidence.h"

namespace sagitta::evidence_test {
namespace {

using test::AllOf;
using test::Integrate;
using test::kInfinity;
using test::Random;
using test::Small;

Eigen::MatrixXd Scaled(int size, double scale) { return scale * Eigen::MatrixXd::Identity(size, size); }

// To the log evidence of nothing.
double Added(const ResidualLikelihood& likelihood, double residual, const GroupGain& gain) {
  return likelihood.Log(residual - gain.quad) - likelihood.Log(residual) - 0.5 * gain.log_det;
}

TEST(EvidenceScore, IsTheMarginalLikelihoodOverThatOfNothing) {
  for (const int count : {1, 3}) {
    const Small small(12, 4, count, 5);
    const ProjectedNormal normal = small.Normal();
    const ResidualLikelihood known(normal.dof, kInfinity, 0.0);
    for (const double scale : kScales) {
      const GroupGain gain = GainOf(AllOf(normal), normal.gradient, scale);
      const double direct = small.LogDensity(Scaled(count, scale)) - small.LogDensity(Scaled(count, 0.0));
      EXPECT_NEAR(Added(known, normal.residual, gain), direct, 1e-9) << count << " columns at " << scale;
    }
  }
}

// The density averaged over the sizes a column may have, each as likely.
TEST(EvidenceScore, AGroupAloneIsAveragedOverItsSizes) {
  Small small(12, 4, 2, 5);
  small.residual += 1.5 * small.columns.col(0);
  const ProjectedNormal normal = small.Normal();
  const ResidualLikelihood known(normal.dof, kInfinity, 0.0);
  double mean = 0.0, most = 0.0, best = 0.0;
  for (const double scale : kScales) {
    const double density = std::exp(small.LogDensity(Scaled(2, scale)));
    mean += density / kNumScales;
    if (density <= most) continue;
    most = density;
    best = scale;
  }
  double scale = 0.0;
  const double gain = AverageGain(known, {AllOf(normal), normal.gradient, normal.residual}, &scale);
  EXPECT_NEAR(gain, std::log(mean) - small.LogDensity(Scaled(2, 0.0)), 1e-9);
  EXPECT_EQ(scale, best);
  EXPECT_GT(most, 1.1 * mean);
}

TEST(EvidenceScore, StudentIsTheGammaMixtureOfSigmas) {
  const Small small(12, 4, 2, 9);
  const ProjectedNormal normal = small.Normal();
  const double nu = 7.0;
  const ResidualLikelihood student(normal.dof, nu, 0.0);
  const auto mixture = [&](double scale) {
    return std::log(Integrate(
        [&](double w) {  // 1 / f^2
          const double prior = std::exp(0.5 * nu * std::log(0.5 * nu) - std::lgamma(0.5 * nu) +
                                        (0.5 * nu - 1.0) * std::log(w) - 0.5 * nu * w);
          return prior * std::exp(small.LogDensity(Scaled(2, scale), 1.0 / std::sqrt(w)));
        },
        1e-6, 12.0));
  };
  const GroupGain gain = GainOf(AllOf(normal), normal.gradient, 0.3);
  EXPECT_NEAR(Added(student, normal.residual, gain), mixture(0.3) - mixture(0.0), 1e-6);
  EXPECT_NEAR(student.Log(normal.residual), mixture(0.0), 1e-6);
}

TEST(EvidenceScore, AWrongSigmaIsAFactorEvenInItsLogarithmWithinTwoOrAHundred) {
  const Small small(40, 4, 2, 3);
  ProjectedNormal normal = small.Normal();
  const double wrong = 0.2;
  for (const double stretch : {1.0, 1.3, 9.0}) {
    const double residual = stretch * normal.residual;
    const ResidualLikelihood likelihood(normal.dof, kInfinity, wrong);
    double open = 0.0;
    for (const double edge : {std::log(kUsualFactor), std::log(kWidestFactor)}) {
      const auto density = [&](double u) { return std::exp(-normal.dof * u - 0.5 * residual * std::exp(-2.0 * u)); };
      open += 0.5 * Integrate(density, -edge, edge) / (2.0 * edge);
    }
    const double stated = (1.0 - wrong) * std::exp(-0.5 * residual), other = wrong * open;
    EXPECT_NEAR(likelihood.Log(residual), std::log(stated + other), 1e-6) << stretch;
    EXPECT_NEAR(likelihood.ProbabilityWrong(residual), other / (stated + other), 1e-6) << stretch;
  }
}

TEST(EvidenceScore, NothingStatedDependsOnTheRatioAlone) {
  const ResidualLikelihood open(30.0, 0.0, 0.1);
  EXPECT_NEAR(open.Log(20.0) - open.Log(40.0), 15.0 * std::log(2.0), 1e-12);
  EXPECT_NEAR(open.Log(2e-6) - open.Log(4e-6), 15.0 * std::log(2.0), 1e-9);
  EXPECT_EQ(open.ProbabilityWrong(20.0), 0.0);
}

TEST(Sweep, IsWhatIsLeftBesideTheGivenGroups) {
  const Small small(15, 3, 6, 21);
  const ProjectedNormal normal = small.Normal();
  ColumnGroup first{{1, 4}, {}}, second{{0, 2, 5}, Random(3, 2, 77)}, asked{{3, 0}, Random(2, 2, 78)};
  const Sweep sweep(normal, {&first, &second}, {0.3, 2.0});
  // The given groups' covariance as noise of the rows.
  const Eigen::MatrixXd a = small.left.transpose() * small.columns;
  const Eigen::VectorXd r = small.left.transpose() * small.residual;
  const Eigen::MatrixXd one = 0.3 * a(Eigen::all, first.columns);
  const Eigen::MatrixXd two = 2.0 * a(Eigen::all, second.columns) * second.mixing;
  const Eigen::MatrixXd noise =
      Eigen::MatrixXd::Identity(r.size(), r.size()) + one * one.transpose() + two * two.transpose();
  const Eigen::MatrixXd own = a(Eigen::all, asked.columns) * asked.mixing;
  EXPECT_LT((sweep.Information(asked) - own.transpose() * noise.inverse() * own).norm(), 1e-9);
  EXPECT_LT((sweep.Gradient(asked) - own.transpose() * noise.inverse() * r).norm(), 1e-9);
  EXPECT_NEAR(sweep.residual(), r.dot(noise.inverse() * r), 1e-9);
  EXPECT_NEAR(sweep.members().log_det(), std::log(noise.determinant()), 1e-9);
}

// Scales that go through their values one by one, and a group that leaves: as if conditioned anew.
TEST(Sweep, MembersFollowOneScaleAndOneGroup) {
  const Small small(15, 3, 6, 31);
  const ProjectedNormal normal = small.Normal();
  const ColumnGroup first{{1, 4}, {}}, second{{0, 2, 5}, Random(3, 2, 77)}, third{{3}, {}};
  const std::vector<const ColumnGroup*> groups = {&first, &second, &third};
  Members stepwise(normal, groups, {1.0, 1.0, 1.0});
  const auto expect_same = [](const Members& found, const Members& expected) {
    EXPECT_NEAR(found.residual(), expected.residual(), 1e-9);
    for (size_t k = 0; k < expected.scales().size(); ++k) {
      const GivenOthers own = found.Of(k), anew = expected.Of(k);
      EXPECT_LT((own.information - anew.information).norm(), 1e-8 * anew.information.norm());
      EXPECT_LT((own.gradient - anew.gradient).norm(), 1e-8 * anew.gradient.norm());
      EXPECT_NEAR(own.residual, anew.residual, 1e-9);
      EXPECT_NEAR(own.log_det, anew.log_det, 1e-9);
    }
  };
  for (const double scale : {3.0, 0.03, 1.0, 0.1, 3.0, 0.3}) {
    for (size_t k = 0; k < groups.size(); ++k) {
      stepwise.Rescale(k, scale);
      const Members anew(normal, groups, stepwise.scales());
      expect_same(stepwise, anew);
      std::vector<const ColumnGroup*> others = groups;
      std::vector<double> theirs = stepwise.scales();
      others.erase(others.begin() + static_cast<long>(k));
      theirs.erase(theirs.begin() + static_cast<long>(k));
      const Members of_others(normal, others, theirs);
      Members left = stepwise;
      left.Remove(k);
      expect_same(left, of_others);
      left.Insert(k, *groups[k], stepwise.scales()[k]);
      expect_same(left, stepwise);
    }
  }
}

// Groups come and go in any order, to none and back: as if swept anew.
TEST(Sweep, FollowsGroupsThatComeAndGo) {
  const Small small(15, 3, 6, 31);
  const ProjectedNormal normal = small.Normal();
  const ColumnGroup first{{1, 4}, {}}, second{{0, 2, 5}, Random(3, 2, 77)}, third{{3}, {}}, asked{{3, 0}, {}};
  Sweep moving(normal, {}, {});
  std::vector<const ColumnGroup*> groups;
  std::vector<double> scales;
  const auto expect_same = [&] {
    const Sweep anew(normal, groups, scales);
    for (const ColumnGroup* group : {&first, &second, &third, &asked}) {
      EXPECT_LT((moving.Information(*group) - anew.Information(*group)).norm(), 1e-9);
      EXPECT_LT((moving.Gradient(*group) - anew.Gradient(*group)).norm(), 1e-9);
    }
    EXPECT_NEAR(moving.residual(), anew.residual(), 1e-9);
    EXPECT_NEAR(moving.members().log_det(), anew.members().log_det(), 1e-9);
  };
  const auto insert = [&](size_t place, const ColumnGroup& group, double scale) {
    moving.Insert(place, group, scale);
    groups.insert(groups.begin() + static_cast<long>(place), &group);
    scales.insert(scales.begin() + static_cast<long>(place), scale);
    expect_same();
  };
  const auto remove = [&](size_t place) {
    moving.Remove(place);
    groups.erase(groups.begin() + static_cast<long>(place));
    scales.erase(scales.begin() + static_cast<long>(place));
    expect_same();
  };
  insert(0, second, 0.3);
  insert(0, first, 3.0);
  insert(1, third, 1.0);
  remove(2);
  remove(0);
  remove(0);
  insert(0, third, 0.1);
  insert(1, second, 3.0);
  insert(2, first, 1.0);
  remove(1);  // what comes next has its place, or is too large for it
  insert(0, second, 0.3);
  remove(1);
  remove(0);
  insert(1, third, 1.0);
  insert(1, second, 1.0);
}

// Of three groups each in turn: by leaving it out, and by removing it from the sweep with all.
TEST(Sweep, WithoutOneIsTheSweepOfTheOthers) {
  const Small small(15, 3, 6, 31);
  const ProjectedNormal normal = small.Normal();
  const ColumnGroup first{{1, 4}, {}}, second{{0, 2, 5}, Random(3, 2, 77)}, third{{3}, {}}, asked{{3, 0}, {}};
  const std::vector<const ColumnGroup*> groups = {&first, &second, &third};
  const std::vector<double> scales = {0.3, 2.0, 1.0};
  const Sweep all(normal, groups, scales);
  const Members members(normal, groups, scales);
  for (size_t k = 0; k < groups.size(); ++k) {
    std::vector<const ColumnGroup*> others = groups;
    std::vector<double> theirs = scales;
    others.erase(others.begin() + static_cast<long>(k));
    theirs.erase(theirs.begin() + static_cast<long>(k));
    const Sweep direct(normal, others, theirs);
    const Sweep::WithoutOne without = all.Without(k);
    const Eigen::MatrixXd solved = all.Solved(asked);
    EXPECT_LT((all.Information(asked) + without.Information(solved) - direct.Information(asked)).norm(), 1e-9);
    EXPECT_LT((all.Gradient(asked) + without.Gradient(solved) - direct.Gradient(asked)).norm(), 1e-9);
    EXPECT_LT((ColumnsOf(asked, all.Gradients({without})).transpose() - direct.Gradient(asked)).norm(), 1e-9);
    // What any information that is no less can explain at any scale is no more than by the least.
    const double most = MostQuads(all.Information(asked), direct.Gradient(asked))[0];
    for (const double scale : kScales) {
      const GroupGain gain = GainOf(direct.Information(asked), direct.Gradient(asked), scale);
      EXPECT_LE(gain.quad, most + 1e-9);
    }
    const ColumnGroup one{{3}, {}};
    EXPECT_NEAR(MostQuads(direct.Information(one), direct.Gradient(one))[0],
                GainOf(direct.Information(one), direct.Gradient(one), kWidestScale).quad, 1e-9);
    EXPECT_NEAR(without.residual, direct.residual(), 1e-9);
    EXPECT_NEAR(without.log_det, direct.members().log_det(), 1e-9);
    const GivenOthers own = members.Of(k);
    EXPECT_LT((own.information - direct.Information(*groups[k])).norm(), 1e-9);
    EXPECT_LT((own.gradient - direct.Gradient(*groups[k])).norm(), 1e-9);
    EXPECT_NEAR(own.residual, direct.residual(), 1e-9);
    EXPECT_NEAR(own.log_det, direct.members().log_det(), 1e-9);
  }
}

TEST(Sweep, ValuesAreThoseOfRidgeRegression) {
  const Small small(15, 3, 4, 23);
  const ColumnGroup group{{0, 2, 3}, {}};
  const GroupValues found = ValuesOf(small.Normal(), {&group}, {0.5});
  const Eigen::MatrixXd a = small.left.transpose() * small.columns(Eigen::all, group.columns);
  Eigen::MatrixXd rows(a.rows() + 3, 3);
  rows << a, Eigen::MatrixXd::Identity(3, 3) / 0.5;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(rows.rows());
  right.head(a.rows()) = -(small.left.transpose() * small.residual);
  EXPECT_LT((found.values - rows.colPivHouseholderQr().solve(right)).norm(), 1e-9);
  EXPECT_LT((found.covariance - (rows.transpose() * rows).inverse()).norm(), 1e-9);
}

// Every subset without two of one number, by its own evaluation.
std::map<std::vector<int>, double> Enumerated(const SetSearch& search, const std::vector<Explanation>& list) {
  std::map<std::vector<int>, double> weights;
  for (int bits = 0; bits < 1 << list.size(); ++bits) {
    std::vector<int> members;
    std::map<int, int> taken;
    for (size_t k = 0; k < list.size(); ++k) {
      if ((bits >> k & 1) == 0) continue;
      members.push_back(static_cast<int>(k));
      ++taken[list[k].excludes];
    }
    const bool allowed = std::all_of(taken.begin(), taken.end(), [](const auto& entry) { return entry.second == 1; });
    if (allowed) weights[members] = search.Evaluate(members).log_weight;
  }
  return weights;
}

std::vector<int> BestOf(const std::map<std::vector<int>, double>& weights) {
  const auto is_less = [](const auto& a, const auto& b) { return a.second < b.second; };
  return std::max_element(weights.begin(), weights.end(), is_less)->first;
}

// Two true causes, and one wide group that imitates both: greedy addition adds that one first.
TEST(SetSearch, FindsWhatEnumerationFinds) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Small small(60, 3, 9, 100 * seed);
    small.columns.col(6) = small.columns.col(0) + 0.6 * small.columns.col(6);
    small.columns.col(7) = small.columns.col(1) + 0.6 * small.columns.col(7);
    small.residual += 1.0 * small.columns.col(0) - 0.8 * small.columns.col(1);
    std::vector<Explanation> list;
    for (int k = 0; k < 6; ++k) list.push_back({{{k}, {}}, 0.12, k});
    list.push_back({{{6, 7, 8}, {}}, 0.16, 6});
    list.push_back({{{2, 3}, {}}, 0.12, 2});
    const ProjectedNormal normal = small.Normal();
    SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.05));
    search.ClimbFrom();
    const std::vector<WeightedSet> found = search.Explore();
    const std::map<std::vector<int>, double> all = Enumerated(search, list);
    double sum = 0.0, kept = 0.0;
    for (const auto& [members, weight] : all) sum += std::exp(weight - found[0].log_weight);
    for (const WeightedSet& set : found) {
      // Those that hold all but a thousandth are evaluated by themselves: exactly, or about the best scales.
      const double near = set.members.size() <= 3 ? 1e-9 : 0.3;
      if (kept < 0.9 * sum) {
        EXPECT_NEAR(set.log_weight, all.at(set.members), near) << "seed " << seed;
      }
      kept += std::exp(set.log_weight - found[0].log_weight);
      EXPECT_LE(set.log_weight, found[0].log_weight);
    }
    EXPECT_EQ(found[0].members, BestOf(all)) << "seed " << seed;
    EXPECT_GT(kept, 0.97 * sum) << "seed " << seed;
  }
}

// A general function holds both causes: neither alone is as good, nor adds anything to it.
TEST(SetSearch, FindsTwoCausesThatAGeneralFunctionHides) {
  int pairs = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Small small(80, 3, 12, 700 + seed);
    for (int k = 6; k < 12; ++k) small.columns.col(k) = small.columns.col(k - 6);
    small.columns.col(6) = small.columns.col(0) + 0.02 * small.columns.col(8);
    small.residual += 3.0 * small.columns.col(0) - 3.0 * small.columns.col(1);
    std::vector<Explanation> list;
    for (int k = 0; k < 6; ++k) list.push_back({{{k}, {}}, 0.02, k});
    list.push_back({{{6, 7, 8, 9, 10, 11}, {}}, 0.88, 6, true});
    const ProjectedNormal n = small.Normal();
    SetSearch search(n, list, {0.5, 0.3}, ResidualLikelihood(n.dof, kInfinity, 0.05));
    search.ClimbFrom();
    EXPECT_EQ(search.Best().members, BestOf(Enumerated(search, list))) << "seed " << seed;
    pairs += search.Best().members == std::vector<int>{0, 1};
  }
  EXPECT_GE(pairs, 5);
}

// Three members with mixing: the average of the density over all combinations of scales.
TEST(SetSearch, AveragesOverTheScalesOfThreeTogether) {
  Small small(20, 2, 5, 18);
  small.columns.col(1) += 2.0 * small.columns.col(0);
  small.residual += 2.0 * small.columns.col(1);
  const ProjectedNormal normal = small.Normal();
  const Eigen::MatrixXd mixing = Random(3, 2, 79);
  const std::vector<Explanation> list = {{{{0}, {}}, 0.3, 0}, {{{1}, {}}, 0.3, 1}, {{{2, 3, 4}, mixing}, 0.4, 2}};
  const SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.0));
  std::vector<double> logs;
  for (const double a : kScales) {
    for (const double b : kScales) {
      for (const double c : kScales) {
        Eigen::MatrixXd root = Eigen::MatrixXd::Zero(5, 4);
        root(0, 0) = a;
        root(1, 1) = b;
        root.bottomRightCorner(3, 2) = c * mixing;
        logs.push_back(small.LogDensity(root));
      }
    }
  }
  const double average = LogSumExp(logs) - std::log(216.0), nothing = small.LogDensity(Scaled(5, 0.0));
  const WeightedSet whole = search.Evaluate({0, 1, 2});
  EXPECT_NEAR(whole.log_likelihood - search.Evaluate({}).log_likelihood, average - nothing, 1e-9);
  const std::vector<double> losses = search.LossesOf(whole);
  const std::vector<std::vector<int>> others = {{1, 2}, {0, 2}, {0, 1}};
  for (size_t m = 0; m < others.size(); ++m) {
    EXPECT_NEAR(losses[m], whole.log_weight - search.Evaluate(others[m]).log_weight, 1e-9);
  }
}

// One scale for an explanation of one column: the average over all of them, exactly.
TEST(SetSearch, AveragesOverTheScale) {
  const Small small(20, 2, 1, 8);
  const ProjectedNormal normal = small.Normal();
  const std::vector<Explanation> list = {{{{0}, {}}, 1.0, 0}};
  const SetSearch search(normal, list, {0.5, 0.3}, ResidualLikelihood(normal.dof, kInfinity, 0.0));
  double sum = 0.0;
  for (const double scale : kScales) sum += std::exp(small.LogDensity(Scaled(1, scale))) / kNumScales;
  const double nothing = small.LogDensity(Scaled(1, 0.0));
  EXPECT_NEAR(search.Evaluate({0}).log_weight - search.Evaluate({}).log_weight, std::log(sum) - nothing, 1e-9);
}

// log mean over all combinations of scales of f(R) |Q|^(-1/2), R and Q of the rows [A D; I] by reflections. Bumps of 25
// columns that lie across each other: the condition of Q is 1e8, which with 400 rows leaves 1e-6 of a log unit.
TEST(SetSearch, WideFunctionsThatLieAcrossEachOtherAreAveragedAccurately) {
  constexpr int kRows = 400, kBumps = 25, kGroups = 3;
  Small small(kRows, 2, kGroups * kBumps, 51);
  const Eigen::VectorXd angle = Eigen::VectorXd::LinSpaced(kRows, -1.0, 1.0);
  std::vector<Explanation> list;
  for (int g = 0; g < kGroups; ++g) {
    const Eigen::ArrayXd driver = angle.array() + 0.02 * g * (7.0 * angle.array()).sin();
    list.push_back({{{}, {}}, 1.0 / kGroups, g});
    for (int b = 0; b < kBumps; ++b) {
      const double center = -2.0 + 4.0 * b / (kBumps - 1.0);  // some beyond the rows
      small.columns.col(kBumps * g + b) = 300.0 * (-0.5 * ((driver - center) / 0.2).square()).exp().matrix();
      list.back().group.columns.push_back(kBumps * g + b);
    }
  }
  small.residual = 30.0 * small.residual + 100.0 * (3.0 * angle.array()).sin().matrix() + 200.0 * angle;
  const ProjectedNormal normal = small.Normal();
  const ResidualLikelihood likelihood(normal.dof, kInfinity, 0.05);
  const WeightedSet set = SetSearch(normal, list, {0.5, 0.3}, likelihood).Evaluate({0, 1, 2});

  const Eigen::MatrixXd a = small.left.transpose() * small.columns;
  const long n = a.cols();
  Eigen::VectorXd right = Eigen::VectorXd::Zero(a.rows() + n);
  right.head(a.rows()) = small.left.transpose() * small.residual;
  std::vector<double> logs;
  for (const double one : kScales) {
    for (const double two : kScales) {
      for (const double three : kScales) {
        Eigen::MatrixXd rows = Eigen::MatrixXd::Identity(a.rows() + n, n);
        rows.topRows(a.rows()) = a;
        rows.bottomRows(n).setIdentity();
        const double scale[kGroups] = {one, two, three};
        for (long c = 0; c < n; ++c) rows.col(c).head(a.rows()) *= scale[c / kBumps];
        const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
        const Eigen::VectorXd turned = qr.householderQ().transpose() * right;
        logs.push_back(likelihood.Log(turned.tail(a.rows()).squaredNorm()) -
                       qr.matrixQR().diagonal().array().abs().log().sum());
      }
    }
  }
  EXPECT_NEAR(set.log_likelihood, LogSumExp(logs) - std::log(static_cast<double>(logs.size())), 1e-4);
}

// A function of two columns and a piece of one move the rows by as much at every size, none of them by more than causes
// do; a fourth column is another cause.
TEST(NamelessCause, PartsOfOneCauseHaveOneSize) {
  Small small(20, 2, 4, 31);
  small.columns.col(2) *= 7.0;
  small.residual += 0.6 * small.columns.col(0) + 0.2 * small.columns.col(2) + 2.0 * small.columns.col(3);
  const ProjectedNormal normal = small.Normal();
  ExplanationList list;
  list.math = {{{{0, 1}, {}}, 0.2, 0}, {{{2}, {}}, 0.3, 1}, {{{3}, {}}, 0.5, 2}};
  const ResidualLikelihood likelihood(normal.dof, kInfinity, 0.0);
  const SetSearch search(normal, list.math, {0.5, 0.3}, likelihood);
  const WeightedSet many = search.Evaluate({0, 1, 2});
  const WeightedSet one = NamelessCauses::WithOneSize(many, {{0}, {1}}, list.math, normal, likelihood);
  const Eigen::MatrixXd a = small.left.transpose() * small.columns;
  const double unit = a.col(2).norm() / std::sqrt(a.col(0).squaredNorm() + a.col(1).squaredNorm());
  const auto density = [&](double size, double other) {
    const double of_function = std::min(size * unit, 3.0);
    const Eigen::Vector4d scales(of_function, of_function, size, other);
    return small.LogDensity(scales.asDiagonal());
  };
  std::vector<double> as_one, of_other;
  for (const double scale : {0.03, 0.1, 0.3, 1.0, 3.0}) as_one.push_back(density(scale, many.scales[2]));
  for (const double scale : kScales) {
    const Eigen::Vector4d scales(many.scales[0], many.scales[0], many.scales[1], scale);
    of_other.push_back(small.LogDensity(scales.asDiagonal()));
  }
  const double lost = LogSumExp(of_other) - *std::max_element(of_other.begin(), of_other.end());
  const double expected =
      LogSumExp(as_one) + lost - std::log(5.0) - std::log(kNumScales) - small.LogDensity(Scaled(4, 0.0));
  EXPECT_NEAR(one.log_likelihood - search.Evaluate({}).log_likelihood, expected, 1e-9);
  EXPECT_NEAR(one.log_weight - one.log_likelihood, many.log_weight - many.log_likelihood, 1e-12);
  EXPECT_EQ(one.members, many.members);
  EXPECT_NEAR(one.scales[0], std::min(one.scales[1] * unit, 3.0), 1e-12);
  EXPECT_EQ(one.scales[2], many.scales[2]);
}

// A search for a factor looks an octave around where it begins: what one beginning has missed says nothing of another.
TEST(NoisePart, WhereItsSearchBeginsIsPartOfIt) {
  const ReadingGroup group{ReadingGroup::Kind::kMarker, 1};
  const NoisePart low{NoiseView::Kind::kStated, group, 0.5}, high{NoiseView::Kind::kStated, group, 4.0};
  EXPECT_TRUE(low < high);
  EXPECT_FALSE(low < low);
}

}  // namespace
}  // namespace sagitta::evidence_test
