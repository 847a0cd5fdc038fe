// A file that was read, named by what it held.
#pragma once

#include <string>

namespace sagitta {

struct InputFile {
  std::string path;
  std::string sha256;  // lower-case hex
};

}  // namespace sagitta
