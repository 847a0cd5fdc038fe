#include "models/dense_algebra.h"

template class Eigen::BDCSVD<Eigen::MatrixXd>;
