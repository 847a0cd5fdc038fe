#define SAGITTA_SVD_TEMPLATE template
#include "models/dense_algebra.h"
