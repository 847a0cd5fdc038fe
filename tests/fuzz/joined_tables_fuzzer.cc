#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, size_t size) {
  return sagitta::fuzz::Feed(sagitta::fuzz::ReadJoinedTables, data, size);
}
