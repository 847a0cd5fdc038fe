// A failure that has words of ours: no bad input, and no exception of a library, whose text would help nobody.
#pragma once

#include <stdexcept>

namespace sagitta {

class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace sagitta
