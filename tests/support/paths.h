// Where the tests find the tree, the data next to it and the built program.
#pragma once

#include <string>

namespace sagitta::test {

std::string SourceFolder();
std::string SharedFolder();  // absent on machines without the shared data: such tests skip
std::string Program();

}  // namespace sagitta::test
