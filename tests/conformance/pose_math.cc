#include "conformance/pose_math.h"

#include <algorithm>
#include <cmath>

#include "twin/core/time.h"

namespace twin::test {
namespace {

/// Rows r, columns c.
using Rotation = std::array<std::array<double, 3>, 3>;

std::size_t Index(int r, int c) {
  return 4 * static_cast<std::size_t>(c) + static_cast<std::size_t>(r);
}

double At(const Transform& X, int r, int c) {
  return X[Index(r, c)];
}

Rotation ExpOf(const Vector3& phi) {
  const double angle = Norm(phi);
  // sin(x)/x and (1 - cos x)/x^2 by their series near zero.
  const double s = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const double half = angle < 1e-4 ? 1 - angle * angle / 24 : std::sin(angle / 2) / (angle / 2);
  const double c = half * half / 2;
  const Rotation K{{{0, -phi[2], phi[1]}, {phi[2], 0, -phi[0]}, {-phi[1], phi[0], 0}}};
  Rotation R{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double square = 0;
      for (std::size_t k = 0; k < 3; ++k) square += K[i][k] * K[k][j];
      R[i][j] = (i == j ? 1.0 : 0.0) + s * K[i][j] + c * square;
    }
  }
  return R;
}

}  // namespace

double Norm(const Vector3& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

Vector3 Linear(const Vector6& twist) {
  return {twist[0], twist[1], twist[2]};
}

Vector3 Angular(const Vector6& twist) {
  return {twist[3], twist[4], twist[5]};
}

Vector3 RotationBetween(const Transform& from, const Transform& to) {
  Rotation R{};  // R_to R_from^T
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += At(to, i, k) * At(from, j, k);
      R[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = sum;
    }
  }
  Vector3 axis{(R[2][1] - R[1][2]) / 2, (R[0][2] - R[2][0]) / 2, (R[1][0] - R[0][1]) / 2};
  const double sine = Norm(axis);
  const double cosine = (R[0][0] + R[1][1] + R[2][2] - 1) / 2;
  const double angle = std::atan2(sine, cosine);
  if (cosine < -0.99) {  // near half a turn the axis is in the symmetric part
    std::size_t k = 0;
    for (std::size_t i = 1; i < 3; ++i) k = R[i][i] > R[k][k] ? i : k;
    Vector3 column{R[0][k] + R[k][0], R[1][k] + R[k][1], R[2][k] + R[k][2]};
    column[k] -= 2 * cosine;
    const double length = Norm(column);
    const double sign =
        column[0] * axis[0] + column[1] * axis[1] + column[2] * axis[2] < 0 ? -1 : 1;
    for (double& x : column) x *= sign * angle / length;
    return column;
  }
  const double scale = sine > 1e-9 ? angle / sine : 1.0;
  for (double& x : axis) x *= scale;
  return axis;
}

Transform Turned(const Transform& X, const Vector3& phi) {
  const Rotation R = ExpOf(phi);
  Transform turned = X;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        sum += R[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] * At(X, k, j);
      }
      turned[Index(i, j)] = sum;
    }
  }
  return turned;
}

Transform After(const Transform& X, const Vector6& twist) {
  Vector3 phi = Angular(twist);
  for (double& x : phi) x *= kT;
  Transform moved = Turned(X, phi);
  for (std::size_t i = 0; i < 3; ++i) moved[12 + i] = X[12 + i] + kT * twist[i];
  return moved;
}

Vector6 TwistBetween(const Transform& from, const Transform& to) {
  const Vector3 phi = RotationBetween(from, to);
  Vector6 twist{};
  for (std::size_t i = 0; i < 3; ++i) {
    twist[i] = (to[12 + i] - from[12 + i]) / kT;
    twist[3 + i] = phi[i] / kT;
  }
  return twist;
}

double Obliqueness(const Transform& X) {
  double worst = 0;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      double dot = 0;
      for (int r = 0; r < 3; ++r) dot += At(X, r, a) * At(X, r, b);
      const double off = std::abs(dot - (a == b ? 1 : 0));
      worst = off <= worst ? worst : off;  // NaN counts
    }
  }
  return worst;
}

}  // namespace twin::test
