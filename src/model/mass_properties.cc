#include "twin/model/mass_properties.h"

namespace twin::model {
namespace {

/// Adds scale * (-[c]x^2), scale = mass: inertia of a point mass at c about the origin.
void AddPointMass(double scale, const Vector3& c, Matrix3& I) noexcept {
  const double norm2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      const double diagonal = row == column ? norm2 : 0;
      I[3 * column + row] += scale * (diagonal - c[row] * c[column]);
    }
  }
}

/// Adds the body's inertia about the flange.
void AddBody(const Payload& body, Matrix3& I) noexcept {
  if (body.m == 0) return;
  for (std::size_t k = 0; k < I.size(); ++k) I[k] += body.I[k];
  AddPointMass(body.m, body.F_x_C, I);
}

}  // namespace

Payload Combine(const Payload& a, const Payload& b) noexcept {
  Payload total;
  total.m = a.m + b.m;
  if (total.m == 0) return {};
  for (std::size_t k = 0; k < 3; ++k) {
    total.F_x_C[k] = (a.m * a.F_x_C[k] + b.m * b.F_x_C[k]) / total.m;
  }
  AddBody(a, total.I);
  AddBody(b, total.I);
  AddPointMass(-total.m, total.F_x_C, total.I);
  return total;
}

}  // namespace twin::model
