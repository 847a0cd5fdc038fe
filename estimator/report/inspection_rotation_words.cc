#include "estimator/report/inspection_rotation_words.h"

#include "models/constants.h"
#include "problems/text.h"

namespace sagitta {
namespace {

std::string InDegrees(double angle) { return Significant(angle / kDegree, 3) + " deg"; }

}  // namespace

Advice RotationsMiss(const RotationsAsStated& stated, const std::vector<std::string>& fitting, double misfit) {
  const std::string columns = Enumerate(stated.columns);
  const std::string words = "the points fit within " + InMillimetres(stated.points) +
                            " (RMS), the rotations do not: " + columns + " read as " + stated.reading + " miss by " +
                            InDegrees(stated.misfit) + " (RMS)";
  if (fitting.empty()) {
    return {words + ", and no other kind of rotation, unit or direction fits (the best by " + InDegrees(misfit) + ")",
            "check what " + columns +
                " mean, and the signs of joints that turn the target and hardly move it, as the last one may"};
  }
  std::string others = fitting.front() + " by " + InDegrees(misfit);
  for (size_t k = 1; k < fitting.size(); ++k) others += (k == 1 ? ", and as well as " : " and ") + fitting[k];
  return {words + ", as " + others,
          "write the rotation of the target in the measurement frame as a rotation vector (rx_mrad, ry_mrad, rz_mrad) "
          "or as a quaternion, scalar first (ow, ox, oy, oz); 'sagitta import' converts foreign tables"};
}

}  // namespace sagitta
