#include "twin/core/inertia.h"

#include <cmath>

namespace twin {

bool IsInertiaOfBody(const Matrix3& I) noexcept {
  constexpr double kTolerance = 1e-6;  // of the trace
  if (I == Matrix3{}) return true;
  const double trace = I[0] + I[4] + I[8];
  const double tolerance = kTolerance * trace;
  for (const double skew : {I[1] - I[3], I[2] - I[6], I[5] - I[7]}) {
    if (!(std::abs(skew) <= tolerance)) return false;
  }
  // Sylvester's criterion for Sigma + tolerance 1. NaN fails every comparison.
  const double xx = trace / 2 - I[0] + tolerance;
  const double yy = trace / 2 - I[4] + tolerance;
  const double zz = trace / 2 - I[8] + tolerance;
  const double xy = -I[1];
  const double xz = -I[2];
  const double yz = -I[5];
  const double minor = xx * yy - xy * xy;
  const double determinant = zz * minor - xx * yz * yz - yy * xz * xz + 2 * xy * xz * yz;
  return xx > 0 && minor > 0 && determinant > 0;
}

}  // namespace twin
