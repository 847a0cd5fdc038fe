#include "models/dense_algebra.h"

#define SAGITTA_TEMPLATE template
#include "models/dense_templates.h"
