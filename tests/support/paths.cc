#include "tests/support/paths.h"

namespace sagitta::test {

// Defined for this one source: the others compile alike wherever the tree lies.
std::string SourceFolder() { return SAGITTA_SOURCE_DIR; }
std::string SharedFolder() { return SAGITTA_SHARED_DIR; }
std::string Program() { return SAGITTA_PROGRAM; }

}  // namespace sagitta::test
