#include "reference/fixed_point/polytope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "twin/core/random.h"

namespace twin::reference::polytope_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Polytope::Rows CubeRows() {
  return {Vector3d::UnitX(),  -Vector3d::UnitX(), Vector3d::UnitY(),
          -Vector3d::UnitY(), Vector3d::UnitZ(),  -Vector3d::UnitZ()};
}

/// Rows that touch the unit ball, or nearly, all over.
Polytope::Rows RoundRows(int count, std::uint64_t seed) {
  const Random random(seed, RandomStream::kTest);
  Polytope::Rows rows;
  for (int i = 0; i < count; ++i) {
    const auto tick = static_cast<std::uint64_t>(i);
    const Vector3d way(random.Normal(tick, 1), random.Normal(tick, 2), random.Normal(tick, 3));
    rows.push_back(way.normalized() * (0.9 + 0.1 * random.Uniform(tick, 4)));
  }
  return rows;
}

Vector3d PointOf(const Random& random, int i, double size) {
  const auto tick = static_cast<std::uint64_t>(i);
  const Vector3d unit(random.Uniform(tick, 1), random.Uniform(tick, 2), random.Uniform(tick, 3));
  return size * (2 * unit - Vector3d::Ones());
}

TEST(PolytopeTest, ACubeHasEightCornersAndTwelveEdges) {
  const Polytope cube(CubeRows());
  EXPECT_EQ(cube.rows().size(), 6U);
  for (const Vector3d& corner : cube.corners()) {
    EXPECT_LT((corner.cwiseAbs() - Vector3d::Ones()).norm(), 1e-12);
  }
  // Of the pairs of faces, all but the three of opposite ones share an edge.
  EXPECT_EQ(cube.edges().size(), 12U);
}

TEST(PolytopeTest, LeavesOutRowsThatNoPointNeeds) {
  Polytope::Rows rows = CubeRows();
  rows.emplace_back(0.3, 0.3, 0.3);  // touches nothing
  rows.emplace_back(0.4, 0.4, 0.4);  // cuts three corners' worth: x + y + z <= 2.5
  const Polytope cut(rows);
  EXPECT_EQ(cut.rows().size(), 7U);
  EXPECT_GT(cut.Excess({0.95, 0.95, 0.95}), 0);
  EXPECT_LT(cut.Excess({0.95, 0.95, 0.5}), 0);
}

TEST(PolytopeTest, WhatIsLeftOfTheRowsIsTheSameSet) {
  const Polytope::Rows rows = RoundRows(300, 1);
  const Polytope set(rows);
  ASSERT_LT(set.rows().size(), rows.size());
  const Random random(2, RandomStream::kTest);
  for (int i = 0; i < 4000; ++i) {
    const Vector3d x = PointOf(random, i, 1.5);
    double most = -1;
    for (const Vector3d& g : rows) most = std::max(most, g.dot(x) - 1);
    if (std::abs(most) < 1e-12) continue;
    ASSERT_EQ(most <= 0, set.Excess(x) <= 0) << x.transpose();
  }
}

TEST(PolytopeTest, AChordEndsOnTheBorder) {
  const Polytope set(RoundRows(100, 3));
  const Vector3d x(0.1, -0.2, 0.3);
  const Vector3d d(0.5, 1, -0.2);
  const auto [first, last] = set.Chord(x, d);
  EXPECT_NEAR(set.Excess(x + first * d), 0, 1e-12);
  EXPECT_NEAR(set.Excess(x + last * d), 0, 1e-12);
  EXPECT_LT(first, last);
  const auto [from, to] = set.Chord({5, 5, 5}, Vector3d::UnitX());
  EXPECT_GT(from, to);
}

TEST(PolytopeTest, RefusesRowsThatBoundNothing) {
  Polytope::Rows open = CubeRows();
  open.pop_back();
  EXPECT_THROW(Polytope{open}, std::invalid_argument);
  EXPECT_THROW(Polytope({Vector3d::UnitX(), -Vector3d::UnitX()}), std::invalid_argument);
}

/// Fourier-Motzkin with every pair of rows.
Polytope::Rows AllPairsBefore(const Polytope& set, const Matrix3d& A, const Vector3d& b) {
  Polytope::Rows rows;
  for (const Vector3d& g : set.rows()) {
    rows.emplace_back(A.transpose() * g / (1 + std::abs(g.dot(b))));
    for (const Vector3d& h : set.rows()) {
      const double up = g.dot(b);
      const double down = h.dot(b);
      if (up > 0 && down < 0) {
        rows.emplace_back(A.transpose() * (-down * g + up * h) / (up - down));
      }
    }
  }
  return rows;
}

TEST(PolytopeTest, PairsThatShareAnEdgeAreEnoughForEliminating) {
  Matrix3d A;
  A << 1, 0.2, 0.1, 0, 1, 0.2, 0.1, 0, 1;
  const Vector3d b(0.05, 0.2, 0.4);
  for (const std::uint64_t seed : {4, 5, 6}) {
    const Polytope set(RoundRows(60, seed));
    const Polytope by_edges(RowsBefore(set, A, b));
    const Polytope by_all(AllPairsBefore(set, A, b));
    for (const Vector3d& corner : by_edges.corners()) EXPECT_LT(by_all.Excess(corner), 1e-12);
    for (const Vector3d& corner : by_all.corners()) EXPECT_LT(by_edges.Excess(corner), 1e-12);
  }
}

TEST(PolytopeTest, BeforeIsWhatACommandLeadsIntoTheSetFrom) {
  Matrix3d A;
  A << 1, 0.2, 0.1, 0, 1, 0.2, 0.1, 0, 1;
  const Vector3d b(0.05, 0.2, 0.4);
  const Polytope set(RoundRows(60, 7));
  const Polytope before(RowsBefore(set, A, b));
  const Random random(8, RandomStream::kTest);
  for (int i = 0; i < 3000; ++i) {
    const Vector3d x = PointOf(random, i, 1.5);
    const auto [first, last] = set.Chord(A * x, b);
    const bool leads = std::max(first, -1.0) <= std::min(last, 1.0);
    if (std::abs(before.Excess(x)) < 1e-12) continue;
    ASSERT_EQ(before.Excess(x) <= 0, leads) << x.transpose();
  }
}

}  // namespace
}  // namespace twin::reference::polytope_test
