#include "estimator/evidence/revisits.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "estimator/least_squares/linearization.h"
#include "estimator/planning/pose_space.h"
#include "problems/simulation.h"

namespace sagitta {
namespace {

constexpr int kDraws = 2000;  // of each answer: an expectation to a hundredth
constexpr std::uint64_t kDrawSeed = 1;

std::vector<int> FittedConfigurations(const Measurements& data, const std::vector<std::vector<int>>& observations) {
  std::vector<int> fitted;
  for (size_t c = 0; c < data.configurations.size(); ++c) {
    if (!data.configurations[c].is_validation && !observations[c].empty()) fitted.push_back(static_cast<int>(c));
  }
  return fitted;
}

// m_i of a configuration's readings, its first visit's.
Eigen::VectorXd SizesOfDeviations(const CalibrationProblem& problem, const ParameterSet& parameters,
                                  const std::vector<int>& observations) {
  const Measurements& data = problem.data();
  std::vector<int> own;
  for (const int i : observations) {
    const std::string& first = data.shots[data.observations[observations[0]].shot].visit;
    if (data.shots[data.observations[i].shot].visit == first) own.push_back(i);
  }
  const Linearization here =
      Linearize(problem, parameters, own, {}, ObservationNoise(problem, own, kFallbackSigma), LatentTreatment::kIgnore);
  const Eigen::MatrixXd square = here.latent.transpose() * here.latent;
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(square, Eigen::EigenvaluesOnly).eigenvalues().cwiseMax(0.0);
}

// Of log odds after each further pose, drawn from one of the answers, the expected probability of that answer.
std::vector<double> ExpectedAfter(const std::vector<Eigen::VectorXd>& sizes, int most) {
  NormalNumbers normal(kDrawSeed);
  std::vector<double> expected(static_cast<size_t>(most), 0.0);
  for (const bool deviates : {true, false}) {
    for (int draw = 0; draw < kDraws; ++draw) {
      double odds = 0.0;  // logarithm, of deviating
      for (int k = 0; k < most; ++k) {
        for (const double m : sizes[static_cast<size_t>(k) % sizes.size()]) {
          const double z = normal() * (deviates ? std::sqrt(1.0 + m) : 1.0);
          odds += 0.5 * (z * z * m / (1.0 + m) - std::log1p(m));
        }
        expected[k] += 0.5 / kDraws / (1.0 + std::exp(deviates ? -odds : odds));
      }
    }
  }
  return expected;
}

}  // namespace

NextPoses ProposeRevisits(const CalibrationProblem& deviating, const ParameterSet& parameters) {
  const Measurements& data = deviating.data();
  const std::vector<std::vector<int>> observations = ObservationsByConfiguration(data);
  const std::vector<int> fitted = FittedConfigurations(data, observations);
  const size_t count = std::min<size_t>(kPosesAgain, fitted.size());
  NextPoses next;
  next.again = true;
  next.of_probability = next.decided = kNotKnown;
  std::vector<Eigen::VectorXd> sizes;
  for (size_t k = 0; k < count; ++k) {
    const int own = fitted[k * fitted.size() / count];
    next.poses.push_back({data.configurations[own].q, own});
    sizes.push_back(SizesOfDeviations(deviating, parameters, observations[own]));
  }
  const std::vector<double> expected = ExpectedAfter(sizes, kMostNeeded);
  next.decides = expected[count - 1];
  const auto enough = std::find_if(expected.begin(), expected.end(), [](double p) { return p >= kWanted; });
  next.needed = enough == expected.end() ? 0 : static_cast<int>(enough - expected.begin()) + 1;
  return next;
}

}  // namespace sagitta
