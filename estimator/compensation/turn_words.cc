#include "estimator/compensation/turn_words.h"

namespace sagitta {

std::string TurnsInWords() {
  return "a joint has made a whole turn, and which one the file does not say: --turn_joints=1,4,6 states it (the "
         "controller's $SCR_GRP[1].$TURN_AXIS), and joint limits in the robot file may tell it";
}

}  // namespace sagitta
