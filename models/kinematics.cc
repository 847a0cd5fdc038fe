#include "models/kinematics.h"

namespace sagitta {

template void EvaluateChain(const Chain& chain, const double* values, ChainState<double>* state);

std::vector<Pose<double>> NominalFrames(const Chain& chain, const Eigen::VectorXd& q) {
  const Eigen::VectorXd coupled = chain.CoupledJointValues(q);
  std::vector<double> values;
  for (const ElementaryTransform& transform : chain.transforms) {
    values.push_back(transform.nominal + (transform.has_joint() ? transform.sign * coupled[transform.joint] : 0.0));
  }
  ChainState<double> state;
  EvaluateChain(chain, values.data(), &state);
  return state.frames;
}

}  // namespace sagitta
