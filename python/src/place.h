#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "twin/core/error.h"
#include "twin/core/joint_vector.h"

namespace twin::python {

/// Position and quaternion w x y z.
using Place = std::array<double, 7>;

/// @throws InputError when the quaternion has no length.
inline Transform PoseOf(const double* place) {
  double quaternion[4];
  std::copy_n(place + 3, 4, quaternion);
  const double norm = std::sqrt(quaternion[0] * quaternion[0] + quaternion[1] * quaternion[1] +
                                quaternion[2] * quaternion[2] + quaternion[3] * quaternion[3]);
  if (!(norm > 1e-6)) throw InputError("pose: its quaternion has no length; give w x y z");
  for (double& part : quaternion) part /= norm;
  const auto& [w, x, y, z] = quaternion;
  return {1 - 2 * (y * y + z * z),
          2 * (x * y + w * z),
          2 * (x * z - w * y),
          0,
          2 * (x * y - w * z),
          1 - 2 * (x * x + z * z),
          2 * (y * z + w * x),
          0,
          2 * (x * z + w * y),
          2 * (y * z - w * x),
          1 - 2 * (x * x + y * y),
          0,
          place[0],
          place[1],
          place[2],
          1};
}

}  // namespace twin::python
