#include "twin/model/transform.h"

namespace twin::model {

Transform Multiply(const Transform& X_AB, const Transform& X_BC) noexcept {
  Transform X_AC = kIdentityTransform;
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t r = 0; r < 3; ++r) {
      const double rotated =
          X_AB[r] * X_BC[4 * c] + X_AB[4 + r] * X_BC[4 * c + 1] + X_AB[8 + r] * X_BC[4 * c + 2];
      X_AC[4 * c + r] = c == 3 ? rotated + X_AB[12 + r] : rotated;
    }
  }
  return X_AC;
}

Transform Inverse(const Transform& X_AB) noexcept {
  Transform X_BA = kIdentityTransform;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) X_BA[4 * c + r] = X_AB[4 * r + c];
    X_BA[12 + r] =
        -(X_AB[4 * r] * X_AB[12] + X_AB[4 * r + 1] * X_AB[13] + X_AB[4 * r + 2] * X_AB[14]);
  }
  return X_BA;
}

}  // namespace twin::model
