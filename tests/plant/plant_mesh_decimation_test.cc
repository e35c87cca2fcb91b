#include "plant/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <set>

#include <gtest/gtest.h>

namespace twin::plant::plant_mesh_decimation_test {
namespace {

constexpr double kRadius = 0.1;
constexpr double kHeight = 0.2;
constexpr int kAround = 120;
constexpr int kAlong = 20;

/// Adds a vertex. @returns its number.
int Add(MeshPart& part, const std::array<double, 3>& p, const std::array<double, 3>& n) {
  for (const double x : p) part.vertices.push_back(static_cast<float>(x));
  for (const double x : n) part.normals.push_back(static_cast<float>(x));
  return static_cast<int>(part.vertices.size() / 3) - 1;
}

/// A can about the z axis with `kAround` faces, its wall smooth and its rims sharp.
MeshPart Can() {
  MeshPart part;
  part.colour = {0.2, 0.4, 0.6, 1};
  const auto point = [](int around, double z) {
    const double angle = 2 * M_PI * around / kAround;
    return std::array{kRadius * std::cos(angle), kRadius * std::sin(angle), z};
  };
  for (int k = 0; k <= kAlong; ++k) {
    for (int i = 0; i < kAround; ++i) {
      const auto p = point(i, kHeight * k / kAlong);
      Add(part, p, {p[0] / kRadius, p[1] / kRadius, 0});
    }
  }
  const auto wall = [](int i, int k) { return k * kAround + i % kAround; };
  for (int k = 0; k < kAlong; ++k) {
    for (int i = 0; i < kAround; ++i) {
      part.faces.insert(part.faces.end(), {wall(i, k), wall(i + 1, k), wall(i + 1, k + 1)});
      part.faces.insert(part.faces.end(), {wall(i, k), wall(i + 1, k + 1), wall(i, k + 1)});
    }
  }
  for (const double side : {-1.0, 1.0}) {
    const double z = side < 0 ? 0 : kHeight;
    const int centre = Add(part, {0, 0, z}, {0, 0, side});
    for (int i = 0; i < kAround; ++i) Add(part, point(i, z), {0, 0, side});
    for (int i = 0; i < kAround; ++i) {
      const int here = centre + 1 + i;
      const int next = centre + 1 + (i + 1) % kAround;
      if (side > 0) part.faces.insert(part.faces.end(), {centre, here, next});
      if (side < 0) part.faces.insert(part.faces.end(), {centre, next, here});
    }
  }
  return part;
}

std::array<double, 3> Row(const std::vector<float>& values, int i) {
  const auto at = 3 * static_cast<std::size_t>(i);
  return {values[at], values[at + 1], values[at + 2]};
}

std::array<double, 3> NormalOf(const MeshPart& part, std::size_t face) {
  const auto a = Row(part.vertices, part.faces[face]);
  const auto b = Row(part.vertices, part.faces[face + 1]);
  const auto c = Row(part.vertices, part.faces[face + 2]);
  const std::array u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const std::array v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  std::array n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::hypot(n[0], n[1], n[2]);
  for (double& x : n) x /= length;
  return n;
}

/// Vertices per triangle that are not among the last 32 computed ones.
double ComputedPerTriangle(const MeshPart& part) {
  std::deque<int> last;
  int computed = 0;
  for (const int vertex : part.faces) {
    if (std::ranges::find(last, vertex) != last.end()) continue;
    ++computed;
    last.push_back(vertex);
    if (last.size() > 32) last.pop_front();
  }
  return 3.0 * computed / static_cast<double>(part.faces.size());
}

/// Enclosed volume, by the divergence theorem.
double Volume(const MeshPart& part) {
  double volume = 0;
  for (std::size_t i = 0; i < part.faces.size(); i += 3) {
    const auto a = Row(part.vertices, part.faces[i]);
    const auto b = Row(part.vertices, part.faces[i + 1]);
    const auto c = Row(part.vertices, part.faces[i + 2]);
    volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0])) /
              6;
  }
  return volume;
}

TEST(MeshDecimationTest, LeavesFewTrianglesOfASurfaceThatBendsOneWay) {
  const MeshPart can = Can();
  EXPECT_LT(Decimate(can, 1e-4).faces.size(), can.faces.size() / 10);
}

TEST(MeshDecimationTest, LeavesFewerWhereMoreErrorIsAllowed) {
  const MeshPart can = Can();
  EXPECT_LT(Decimate(can, 1e-3).faces.size(), Decimate(can, 1e-5).faces.size());
}

TEST(MeshDecimationTest, KeepsTheVolumeWithinAreaTimesError) {
  constexpr double kError = 2e-4;
  constexpr double kArea = 2 * M_PI * kRadius * (kRadius + kHeight);
  const MeshPart can = Can();
  EXPECT_NEAR(Volume(Decimate(can, kError)), Volume(can), kArea * kError);
}

TEST(MeshDecimationTest, UsesPlacesOfThePartOnly) {
  const MeshPart can = Can();
  std::set<std::array<double, 3>> places;
  for (int i = 0; i < static_cast<int>(can.vertices.size() / 3); ++i) {
    places.insert(Row(can.vertices, i));
  }
  const MeshPart fewer = Decimate(can, 2e-4);
  for (int i = 0; i < static_cast<int>(fewer.vertices.size() / 3); ++i) {
    EXPECT_TRUE(places.contains(Row(fewer.vertices, i)));
  }
}

TEST(MeshDecimationTest, KeepsRimsSharpAndWallsSmooth) {
  const MeshPart fewer = Decimate(Can(), 2e-4);
  for (std::size_t i = 0; i < fewer.faces.size(); ++i) {
    const auto n = Row(fewer.normals, fewer.faces[i]);
    const bool lid = std::abs(NormalOf(fewer, i / 3 * 3)[2]) > 0.9;
    EXPECT_EQ(std::abs(n[2]), lid ? 1 : 0);
    if (lid) continue;
    const auto p = Row(fewer.vertices, fewer.faces[i]);
    EXPECT_NEAR((n[0] * p[0] + n[1] * p[1]) / kRadius, 1, 1e-6);
  }
}

TEST(MeshDecimationTest, KeepsTheOutsideOutside) {
  const MeshPart fewer = Decimate(Can(), 2e-4);
  for (std::size_t i = 0; i < fewer.faces.size(); i += 3) {
    const auto face = NormalOf(fewer, i);
    const auto n = Row(fewer.normals, fewer.faces[i]);
    EXPECT_GT(face[0] * n[0] + face[1] * n[1] + face[2] * n[2], 0.9);
  }
}

/// A closed mesh has half a vertex per triangle, which no order falls below.
TEST(MeshDecimationTest, OrdersTrianglesSoThatVerticesAreReused) {
  MeshPart can = Can();
  // Bent both ways, so that few triangles go, and in an order in which neighbours are far apart.
  for (std::size_t i = 0; i < can.vertices.size(); i += 3) {
    const double bulge = 1 + 0.5 * std::sin(M_PI * can.vertices[i + 2] / kHeight);
    can.vertices[i] *= static_cast<float>(bulge);
    can.vertices[i + 1] *= static_cast<float>(bulge);
  }
  const std::vector<int> faces = can.faces;
  const std::size_t triangles = faces.size() / 3;
  for (std::size_t i = 0; i < triangles; ++i) {
    const std::size_t from = i * 1009 % triangles;  // a prime, so every triangle once
    std::copy_n(faces.begin() + static_cast<std::ptrdiff_t>(3 * from), 3,
                can.faces.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  const MeshPart fewer = Decimate(can, 1e-6);
  EXPECT_GT(ComputedPerTriangle(can), 1.5);
  EXPECT_GT(fewer.faces.size(), can.faces.size() / 2);
  EXPECT_LT(ComputedPerTriangle(fewer), 0.8);
}

TEST(MeshDecimationTest, KeepsTheColour) {
  EXPECT_EQ(Decimate(Can(), 2e-4).colour, Can().colour);
}

TEST(MeshDecimationTest, LeavesASpeckAsItIs) {
  MeshPart can = Can();
  for (float& x : can.vertices) x *= 1e-4F;  // 20 micrometres
  EXPECT_EQ(Decimate(can, 1e-3).faces, can.faces);
}

}  // namespace
}  // namespace twin::plant::plant_mesh_decimation_test
