#include "models/dense_algebra.h"

template class Eigen::JacobiSVD<Eigen::MatrixXd>;
