// A noise model of one's own: a tracker that is three times as certain along its line of sight as across it. Prints by
// how much the standard deviations of the geometry change: where the readings scatter otherwise, as those of KR 270 do,
// alike in all directions, they grow by what the residuals say against the model.
//
// usage: own_noise EXPERIMENT.yaml
#include <sagitta/sagitta.h>

#include <cmath>
#include <iostream>

namespace {

// m; root of the covariance of a point that is seen from the station's origin.
sagitta::Matrix3<double> RootOf(const sagitta::Vector3<double>& point, double across) {
  const sagitta::Vector3<double> sight = point.normalized();
  const sagitta::Matrix3<double> along = sight * sight.transpose();
  return across * (sagitta::Matrix3<double>::Identity() - along) + across / 3.0 * along;
}

}  // namespace

int main(int, char** argv) {
  const sagitta::CalibrationProblem stated = sagitta::ReadExperiment({argv[1]});
  sagitta::CalibrationProblem own = stated;
  for (const sagitta::Observation& row : own.data().observations)
    own.resolved_noise.push_back(RootOf(row.point_in_station, 1e-4));
  const sagitta::Calibration before = sagitta::Calibrate(stated), after = sagitta::Calibrate(own);
  if (!sagitta::IsUsable(before.estimate.status) || !sagitta::IsUsable(after.estimate.status)) return 3;
  double change = 0.0;
  int count = 0;
  for (size_t i = 0; i < after.estimate.table.size(); ++i) {
    const sagitta::ParameterEstimate& row = after.estimate.table[i];
    if (row.name.rfind("geometry/", 0) != 0 || !(row.sigma > 0.0)) continue;
    change += std::log(row.sigma / before.estimate.table[i].sigma), ++count;
  }
  std::cout << "standard deviations of " << count << " geometric errors are " << std::exp(change / count)
            << " times those of the stated noise\n";
  const sagitta::Matrix3<double> of_first = RootOf(own.data().observations[0].point_in_station, 1e-4);
  return count > 0 && (after.problem.SqrtCovariance(0) - of_first).norm() < 1e-9 ? 0 : 1;
}
