// Words of the controllers' languages: what stands where a routine could be called and calls none.
#pragma once

#include <set>
#include <string>

namespace sagitta {

// As the controller compares them, in capitals but for URScript. Of FANUC the first words of a statement that has
// neither sign nor bracket: LOCK PREG, COL DETECT ON.
const std::set<std::string>& KrlWords();
const std::set<std::string>& RapidWords();
const std::set<std::string>& UrScriptWords();
const std::set<std::string>& FanucWords();

}  // namespace sagitta
