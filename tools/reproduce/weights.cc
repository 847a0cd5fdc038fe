// Paper 003: sigmas, configurations, intervals and the gain of weights; Fig. 3.
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "estimator/statistics/distributions.h"
#include "problems/simulation.h"
#include "tools/report/charts.h"
#include "tools/reproduce/data.h"

namespace sagitta {
namespace {

constexpr double kModelError = 0.46e-3;  // m, residual RMS of 002, Table VIII
constexpr int kShownIterations = 15;

std::string Triple(const Vector3<double>& values, int decimals) {
  return Fixed(values[0], decimals) + "  " + Fixed(values[1], decimals) + "  " + Fixed(values[2], decimals);
}

ReproducedTable Table1(Reproduction* reproduction) {
  ReproducedTable table{"003-1", "Dispersions of measurement errors in deflections", {}, {}, {}};
  const nlohmann::json& given = reproduction->table("003-1");
  const ElasticRun& run = reproduction->elastic();
  const int n = static_cast<int>(run.design.sigma.size()) / 45;
  NormalNumbers normal(reproduction->options().seed);
  int outside = 0, too_sure = 0;
  for (size_t c = 0; c < run.sigma.size(); ++c) {
    Vector3<double> sample;
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0, squares = 0.0;
      for (int i = 0; i < n; ++i) {
        const double e = run.sigma[c][axis] / kMicro * normal();
        sum += e;
        squares += e * e;
      }
      sample[axis] = std::sqrt((squares - sum * sum / n) / (n - 1));
      const double chi2 = (n - 1) * std::pow(sample[axis] * kMicro / run.sigma[c][axis], 2);
      if (chi2 < ChiSquareQuantile(0.0005, n - 1) || chi2 > ChiSquareQuantile(0.9995, n - 1)) ++outside;
      const double spread = run.sigma[c][axis] / kMicro / std::sqrt(2.0 * (n - 1));
      if (given.at("std_um").at(c).at(axis).get<double>() < 0.5 * spread) ++too_sure;
    }
    table.State("configuration " + std::to_string(c + 1) + ", sigma x y z, um", Triple(run.sigma[c] / kMicro, 0),
                Triple(sample, 0), Reproducibility::kInput,
                "drives the simulation; computed: sample of 18 differences");
  }
  const double ratio = run.design.sigma.maxCoeff() / run.design.sigma.minCoeff();
  table.State("samples outside their 99.9 % range", "-", std::to_string(outside) + " of 45",
              Reproducibility::kAddition);
  table.Compare("largest / smallest sigma", 153.0 / 17.0, ratio, 2, "153 and 17 um of the text").verdict =
      Reproducibility::kInput;
  table.State("printed +- below half the sampling error", "-", std::to_string(too_sure) + " of 45",
              Reproducibility::kNotReproducible,
              "a standard deviation of 18 values is known to 17 %; what the printed +- means is not said");
  table.notes.push_back("The sigmas are of differences loaded - unloaded: of one reading they are sigma / sqrt(2).");
  return table;
}

double ColumnCondition(const Eigen::MatrixXd& rows) {
  const Eigen::MatrixXd scaled = rows * rows.colwise().norm().cwiseInverse().asDiagonal();
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  return singular[0] / singular[singular.size() - 1];
}

// Geometric mean of the OLS standard deviations at equal noise.
double MeanSigma(const Eigen::MatrixXd& rows) {
  WeightDesign design{rows, Eigen::VectorXd::Ones(rows.rows()), {}};
  return std::exp(PredictOlsSigma(design).array().log().mean());
}

}  // namespace

void CompareWithBound(const std::string& name, double published_interval, double bound, ReproducedTable* table) {
  ReproducedRow& row = table->Compare(
      name, published_interval, bound, 4,
      "below the Cramer-Rao bound at the sigmas of Table 1: no unbiased estimator can; k6 depends on where the load "
      "hangs off axis 6, which is not printed (here: centroid of the markers)");
  if (published_interval < 0.9 * bound) row.verdict = Reproducibility::kNotReproducible;
}

// Shared with 000, Table II: the same 15 configurations.
void AddConfigurations(Reproduction* reproduction, ReproducedTable* table) {
  const ElasticRun& run = reproduction->elastic();
  const Eigen::MatrixXd rows = ElasticColumns(*run.model, run.scene, run.columns);
  table->State("configurations, values of q2", "15, 5", std::to_string(run.scene.shots.size()) + ", 5",
               Reproducibility::kInput, "joint angles as shipped drive the simulation");
  table->State("unknowns, condition of their columns", "-", "9, " + Fixed(ColumnCondition(rows), 1),
               Reproducibility::kAddition, "columns of unit norm");
  // Same q2, the other joints at random.
  constexpr int kSets = 200;
  const std::vector<Eigen::VectorXd> random = DrawConfigurations(
      run.model->chain(), kSets * static_cast<int>(run.scene.shots.size()), reproduction->options().seed + 4000);
  int worse = 0;
  ElasticScene scene = run.scene;
  for (int set = 0; set < kSets; ++set) {
    for (size_t s = 0; s < scene.shots.size(); ++s) {
      const double q2 = run.scene.shots[s].conditions.q[1];
      scene.shots[s].conditions.q = random[set * scene.shots.size() + s];
      scene.shots[s].conditions.q[1] = q2;
    }
    worse += MeanSigma(ElasticColumns(*run.model, scene, run.columns)) > MeanSigma(rows) ? 1 : 0;
  }
  table->State(
      "random sets with the same q2 that know k less well", "optimal", Fixed(100.0 * worse / kSets, 0) + " %",
      worse > 0.9 * kSets ? Reproducibility::kReproduced : Reproducibility::kOrderOfMagnitude,
      "by the geometric mean of nine standard deviations; the paper minimised its own measure under cell limits");
}

namespace {

ReproducedTable Table2(Reproduction* reproduction) {
  ReproducedTable table{"003-2", "Measurement configurations", {}, {}, {}};
  AddConfigurations(reproduction, &table);
  return table;
}

// What lambda of eq. (14) does to the claim, where the weights are per residual.
void AddLambda(Reproduction* reproduction, ReproducedTable* table) {
  const ElasticRun& run = reproduction->elastic();
  WeightStudyOptions options;
  options.trials = reproduction->options().trials;
  options.seed = reproduction->options().seed;
  options.progress = reproduction->options().progress;
  options.bias = run.joint1_deflection;
  std::vector<WeightMethod> methods;
  for (const double lambda : {0.5, 1.0, 2.0}) {
    methods.push_back(KnownWeightMethods().back());
    methods.back().lambda = lambda;
  }
  std::string factors;
  std::vector<double> gains;
  for (const MethodStudy& study : StudyWeights(run.off_axis, run.truth, methods, options)) {
    gains.push_back(std::exp(study.claimed_factor.array().log().mean()));
    factors += (factors.empty() ? "" : " | ") + Fixed(gains.back(), 1);
  }
  table->State(
      "lambda = 0.5 | 1 | 2, claimed gain", "alike to all digits", factors,
      gains[2] > 1.01 * gains[0] ? Reproducibility::kNotReproducible : Reproducibility::kReproduced,
      "geometric mean of nine, per residual; values and intervals that agree to every printed digit need weights "
      "in which lambda cancels, and with sigma0 = 10 um it does not");
}

ReproducedTable Table3(Reproduction* reproduction) {
  ReproducedTable table{"003-3", "Compliances with intervals, urad/(N m)", {}, {}, {}};
  const nlohmann::json& given = reproduction->table("compliance");
  const ElasticRun& run = reproduction->elastic();
  WeightDesign iid = run.design;
  iid.sigma.setConstant(kModelError);
  const Eigen::VectorXd ols = 3.0 * PredictOlsSigma(run.design) / kMicro,
                        wls = 3.0 * PredictWlsSigma(run.design) / kMicro;
  const Eigen::VectorXd coarse = 3.0 * PredictOlsSigma(iid) / kMicro;
  const Eigen::VectorXd off_axis = 3.0 * PredictOlsSigma(run.off_axis) / kMicro;
  const Eigen::VectorXd trick = 3.0 * reproduction->weights(true).back().claimed / kMicro;
  const std::string table1 =
      "eq. 8 with Table 1 gives 4 to 11 times less; k6 depends on where the load hangs off axis 6, which is not "
      "printed";
  const std::string common = "a common residual of 0.46 mm (002, Table VIII) instead of Table 1: mostly model error";
  const std::string per_residual =
      "only with each row's own residual read as a sigma, load 100 mm off the centroid, joint 1 not modelled; see "
      "003-4";
  for (int p = 0; p < 9; ++p) {
    const std::string name = given.at("names").at(p);
    const double o = given.at("ols_ci").at(p), w = given.at("wls_ci").at(p);
    table.State(name + ", OLS | WLS", Fixed(given.at("ols").at(p), 3) + " | " + Fixed(given.at("wls").at(p), 3), "",
                Reproducibility::kInput, "values rest on the measurements; the WLS column drives the simulation");
    table.Compare(name + " interval OLS, eq. 8", o, ols[p], 4, table1);
    table.Compare(name + " interval OLS, common residual", o, coarse[p], 4, common, Reproducibility::kOrderOfMagnitude);
    CompareWithBound(name + " interval WLS, eq. 13", w, wls[p], &table);
    table.Compare(name + " interval WLS, per residual", w, trick[p], 4, per_residual,
                  Reproducibility::kOrderOfMagnitude);
  }
  table.Compare("k6 interval OLS, eq. 8, load 100 mm off", given.at("ols_ci").at(8), off_axis[8], 3,
                "the load point is ours", Reproducibility::kOrderOfMagnitude);
  const std::vector<MethodStudy>& studies = reproduction->weights(true);
  AddLambda(reproduction, &table);
  table.notes.push_back("Coverage of 95 % intervals with joint 1 missing from the model: OLS " +
                        Fixed(100.0 * studies.front().Coverage95(), 0) + " %, per residual " +
                        Fixed(100.0 * studies.back().Coverage95(), 0) + " %.");
  return table;
}

// Claimed and actual, urad/(N m): k21 in words, every parameter in the numbers.
void AddStudies(const std::vector<MethodStudy>& studies, const nlohmann::json& names, const std::string& data,
                ReproducedTable* table) {
  for (const MethodStudy& study : studies) {
    const double claim = study.ClaimedOverActual(), c95 = study.Coverage95(), c3s = study.Coverage3s();
    ReproducedRow& row = table->State(
        study.name + data, "-",
        Fixed(claim, 3) + " (k21 " + Fixed(study.claimed[0] / kMicro, 5) + " / " + Fixed(study.actual[0] / kMicro, 5) +
            ") | " + Fixed(100.0 * c95, 1) + " % | " + Fixed(100.0 * c3s, 1) + " %",
        Reproducibility::kAddition,
        "claimed / actual standard deviation, geometric mean of nine (and of k21, urad/(N m)) | coverage of 95 % | of "
        "3-sigma intervals");
    row.numbers = {{"claimed_over_actual", claim}, {"coverage_95", c95}, {"coverage_3_sigma", c3s}};
    for (int p = 0; p < study.claimed.size(); ++p) {
      const std::string name = names.at(p);
      row.numbers["claimed_" + name + "_urad_per_Nm"] = study.claimed[p] / kMicro;
      row.numbers["actual_" + name + "_urad_per_Nm"] = study.actual[p] / kMicro;
      row.numbers["coverage_95_" + name] = study.coverage95[p];
    }
  }
}

ReproducedTable Table4(Reproduction* reproduction) {
  ReproducedTable table{"003-4", "Benefits of weighted least squares", {}, {}, {}};
  const nlohmann::json& given = reproduction->table("compliance");
  const ElasticRun& run = reproduction->elastic();
  const Eigen::VectorXd ols = PredictOlsSigma(run.design), wls = PredictWlsSigma(run.design);
  const double bound = WlsGainBound(run.design.sigma.maxCoeff() / run.design.sigma.minCoeff());
  const std::vector<MethodStudy>& with_joint1 = reproduction->weights(true);
  const std::vector<MethodStudy>& studies = reproduction->weights(false);
  const Eigen::VectorXd& trick = with_joint1.back().claimed_factor;
  const std::string honest = "sigmas 9 to 1 cannot gain more than " + Fixed(bound, 2) + " in any design (Kantorovich)";
  const std::string claimed =
      "weights and sigmas both from each row's own residual, 10 iterations, joint 1 bends but is not modelled; "
      "without it such intervals hold the truth in " +
      Fixed(100.0 * studies.back().Coverage95(), 1) + " % where 95 % is claimed (" +
      Fixed(100.0 * with_joint1.back().Coverage95(), 1) + " % where joint 1 bends as published and is not modelled)";
  for (int p = 0; p < 9; ++p) {
    const std::string name = given.at("names").at(p);
    const double factor = given.at("factor").at(p);
    table.Compare(name + " OLS / WLS, honest", factor, ols[p] / wls[p], 2, honest);
    table.Compare(name + " OLS / WLS, per residual", factor, trick[p], 1, claimed, Reproducibility::kOrderOfMagnitude);
    table.Compare(name + " interval OLS, %, from Table 3", given.at("ols_ci_percent").at(p),
                  100.0 * given.at("ols_ci").at(p).get<double>() / given.at("ols").at(p).get<double>(), 2);
    const double percent = given.at("wls_ci_percent").at(p), wls_value = given.at("wls").at(p);
    ReproducedRow& row = table.Compare(name + " interval WLS, %, from Table 3", percent,
                                       100.0 * given.at("wls_ci").at(p).get<double>() / wls_value, 2,
                                       p == 8 ? "1.28 % here, 1.23 % in the text" : "within the rounding of Table 3");
    // Table 3 prints four decimals, Table 4 two.
    const double rounding = 100.0 * 0.00005 / wls_value + 0.005;
    if (std::abs(row.computed_value - percent) <= rounding) row.verdict = Reproducibility::kReproduced;
  }
  table.State("largest gain any design allows", "27.2 ... 42.0", Fixed(bound, 2), Reproducibility::kNotReproducible,
              honest);
  AddStudies(studies, given.at("names"), "", &table);
  AddStudies({with_joint1[0], with_joint1[1], with_joint1.back()}, given.at("names"), "; joint 1 missing", &table);
  return table;
}

ReproducedTable Figure3(Reproduction* reproduction) {
  ReproducedTable table{"003-fig3", "k21 and its interval, iteration by iteration", {}, {}, {}};
  const nlohmann::json& given = reproduction->table("003-fig3");
  const ElasticRun& run = reproduction->elastic();
  WeightMethod method = KnownWeightMethods().back();
  method.iterations = kShownIterations;
  NormalNumbers normal(reproduction->options().seed);
  Eigen::VectorXd deflections = run.off_axis.rows * run.truth + run.joint1_deflection;
  for (int i = 0; i < deflections.size(); ++i) deflections[i] += run.off_axis.sigma[i] * normal();
  const std::vector<WeightedFit> fits = FitWeighted(run.off_axis, deflections, method);
  for (size_t i = 0; i < fits.size(); ++i) {
    table.State("iteration " + std::to_string(i), i == 0 ? "0.297 +-0.010" : "-",
                Fixed(fits[i].value[0] / kMicro, 5) + " +-" + Fixed(3.0 * fits[i].sigma[0] / kMicro, 5),
                Reproducibility::kAddition,
                "k21 with 3 sigma, urad/(N m), one simulated experiment; the figure has no readable scale");
  }
  std::vector<double> iterations, values, intervals;
  for (const WeightedFit& fit : fits) {
    iterations.push_back(static_cast<double>(iterations.size()));
    values.push_back(fit.value[0] / kMicro);
    intervals.push_back(std::log10(3.0 * fit.sigma[0] / kMicro));
  }
  table.pictures = {CurvePicture("k21 over iterations", "iteration", iterations, "k21, urad/(N m)", values),
                    CurvePicture("Its interval over iterations", "iteration", iterations,
                                 "log10 of 3 sigma in urad/(N m)", intervals)};
  const double later = std::abs(fits.back().sigma[0] / fits[10].sigma[0] - 1.0);
  table.Compare("interval shrinks by, this experiment", given.at("factor"), fits.front().sigma[0] / fits[10].sigma[0],
                1, "eq. 8 over eq. 13, both with |r|, 10 iterations", Reproducibility::kOrderOfMagnitude);
  table.Compare("interval shrinks by, mean of " + std::to_string(reproduction->options().trials), given.at("factor"),
                reproduction->weights(true).back().claimed_factor[0], 1,
                "eq. 8 over eq. 13, both with |r|, 10 iterations", Reproducibility::kOrderOfMagnitude);
  table.State("interval settled after 10 iterations", "yes",
              "changes by " + Fixed(100.0 * later, 0) + " % to iteration 15",
              later < 0.25 ? Reproducibility::kOrderOfMagnitude : Reproducibility::kNotReproducible,
              "weights chase the smallest residuals: it slows down, it need not settle");
  table.Compare("k21 changes by, %", given.at("change_percent"),
                100.0 * std::abs(fits[10].value[0] / fits.front().value[0] - 1.0), 2,
                "a change of 3.3 % of k21 needs model error of the size of the published residual, 0.46 mm");
  table.notes.push_back("True k21: " + Fixed(run.truth[0] / kMicro, 3) +
                        ". An interval that shrinks is no proof of accuracy.");
  return table;
}

}  // namespace

std::vector<ReproducibleTable> WeightTables() {
  return {{"003-1", Table1}, {"003-2", Table2}, {"003-3", Table3}, {"003-4", Table4}, {"003-fig3", Figure3}};
}

}  // namespace sagitta
