#include "reference/quintic_path.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <Eigen/Core>

#include "support/dense.h"
#include "twin/core/random.h"

namespace twin::reference::internal::quintic_spline_test {
namespace {

using Derivatives = std::array<double, 6>;  // value and derivatives 1 to 5 of one joint

/// Value and derivatives by the definition of the coefficients.
Derivatives At(const QuinticSegment& segment, std::size_t joint, double x) {
  Derivatives d{};
  for (std::size_t order = 0; order < 6; ++order) {
    for (std::size_t i = order; i < 6; ++i) {
      double factor = segment.c[joint][i];
      for (std::size_t k = 0; k < order; ++k) factor *= static_cast<double>(i - k);
      d[order] += factor * std::pow(x, static_cast<double>(i - order));
    }
  }
  return d;
}

/// Size of what is added up in At(): rounding is relative to it.
double Magnitude(const QuinticSegment& segment, std::size_t joint, std::size_t order) {
  double sum = 0;
  for (std::size_t i = order; i < 6; ++i) {
    const auto power = static_cast<double>(i - order);
    sum += std::abs(segment.c[joint][i]) * 120 * std::pow(segment.length_s, power);
  }
  return sum;
}

struct Path {
  std::vector<Waypoint> waypoints;
  std::vector<Duration> knots;
};

/// Random points with spacings between 0.1 s and 1 s.
Path RandomPath(std::uint64_t seed, std::size_t points) {
  const Random random(seed, RandomStream::kTest);
  Path path;
  Duration at{};
  for (std::size_t i = 0; i < points; ++i) {
    Waypoint waypoint;
    for (std::size_t j = 0; j < kJoints; ++j) {
      waypoint.q[j] = 2 * random.Uniform(i, static_cast<std::uint32_t>(j)) - 1;
    }
    path.waypoints.push_back(waypoint);
    path.knots.push_back(at);
    at += FromSeconds(std::pow(10, -1 * random.Uniform(i, 100)));
  }
  return path;
}

TEST(FitSplineTest, SingleSegmentIsTheMinimumJerkPolynomial) {
  const std::vector<Waypoint> waypoints{{.q = {}}, {.q = {1, -2, 3, 0, 0, 0, 0}}};
  const std::vector<Duration> knots{Duration::zero(), std::chrono::seconds(2)};
  const auto segments = FitSpline(waypoints, knots);
  ASSERT_EQ(segments.size(), 1u);
  for (const double s : {0.1, 0.35, 0.5, 0.8}) {
    const double shape = s * s * s * (10 + s * (-15 + 6 * s));
    for (std::size_t j = 0; j < kJoints; ++j) {
      EXPECT_NEAR(At(segments[0], j, 2 * s)[0], waypoints[1].q[j] * shape, 1e-14);
    }
  }
}

TEST(FitSplineTest, PassesThroughAllPointsWithContinuousDerivativesToTheFourth) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Path path = RandomPath(seed, 12);
    const auto segments = FitSpline(path.waypoints, path.knots);
    ASSERT_EQ(segments.size(), 11u);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (std::size_t j = 0; j < kJoints; ++j) {
        const double h = segments[i].length_s;
        const Derivatives end = At(segments[i], j, h);
        EXPECT_NEAR(At(segments[i], j, 0)[0], path.waypoints[i].q[j], 1e-13);
        EXPECT_NEAR(end[0], path.waypoints[i + 1].q[j], 1e-15 * Magnitude(segments[i], j, 0));
        if (i + 1 == segments.size()) continue;
        const Derivatives next = At(segments[i + 1], j, 0);
        for (std::size_t order = 1; order <= 4; ++order) {
          const double magnitude =
              std::max(Magnitude(segments[i], j, order), Magnitude(segments[i + 1], j, order));
          EXPECT_NEAR(end[order], next[order], 1e-12 * magnitude)
              << "knot " << i + 1 << " order " << order << " seed " << seed;
        }
      }
    }
  }
}

TEST(FitSplineTest, IsAtRestAtEndsAndStops) {
  Path path = RandomPath(3, 9);
  path.waypoints[4].stop = true;
  const auto segments = FitSpline(path.waypoints, path.knots);
  for (std::size_t j = 0; j < kJoints; ++j) {
    const Derivatives first = At(segments.front(), j, 0);
    const Derivatives last = At(segments.back(), j, segments.back().length_s);
    const Derivatives into_stop = At(segments[3], j, segments[3].length_s);
    const Derivatives from_stop = At(segments[4], j, 0);
    for (const std::size_t order : {1u, 2u}) {
      EXPECT_EQ(first[order], 0);
      EXPECT_EQ(from_stop[order], 0);
      EXPECT_NEAR(last[order], 0, 1e-15 * Magnitude(segments.back(), j, order));
      EXPECT_NEAR(into_stop[order], 0, 1e-15 * Magnitude(segments[3], j, order));
    }
  }
}

TEST(FitSplineTest, PartsBesideAStopDoNotDependOnEachOther) {
  Path path = RandomPath(4, 9);
  path.waypoints[4].stop = true;
  const auto whole = FitSpline(path.waypoints, path.knots);
  path.waypoints[6].q[2] += 0.5;
  const auto changed = FitSpline(path.waypoints, path.knots);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(whole[i].c, changed[i].c);
  EXPECT_NE(whole[4].c, changed[4].c);
}

/// Second implementation: all coefficients of one joint from one dense system of the defining
/// conditions, in the segments' normalised times.
Eigen::VectorXd DenseCoefficients(const Path& path, std::size_t joint) {
  const auto n = static_cast<Eigen::Index>(path.waypoints.size() - 1);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(6 * n);
  const auto length = [&](Eigen::Index i) { return ToSeconds(path.knots[i + 1] - path.knots[i]); };
  const auto derivative = [&](Eigen::Index row, Eigen::Index segment, int order, double s,
                              double sign) {
    for (int i = order; i < 6; ++i) {
      double factor = sign;
      for (int k = 0; k < order; ++k) factor *= i - k;
      a(row, 6 * segment + i) += factor * std::pow(s, i - order);
    }
  };
  Eigen::Index row = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    b(row) = path.waypoints[i].q[joint];
    derivative(row++, i, 0, 0, 1);
    b(row) = path.waypoints[i + 1].q[joint];
    derivative(row++, i, 0, 1, 1);
    if (i + 1 == n) continue;
    for (int order = 1; order <= 4; ++order) {
      derivative(row, i, order, 1, 1);
      derivative(row++, i + 1, order, 0, -std::pow(length(i) / length(i + 1), order));
    }
  }
  for (const int order : {1, 2}) {
    derivative(row++, 0, order, 0, 1);
    derivative(row++, n - 1, order, 1, 1);
  }
  return test::LeastSquares(a, b);
}

TEST(FitSplineTest, AgreesWithADenseSolutionOfTheDefiningConditions) {
  const Path path = RandomPath(7, 8);
  const auto segments = FitSpline(path.waypoints, path.knots);
  for (const std::size_t joint : {0u, 6u}) {
    const Eigen::VectorXd dense = DenseCoefficients(path, joint);
    const double largest = dense.cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        const double normalised =
            segments[i].c[joint][k] * std::pow(segments[i].length_s, static_cast<double>(k));
        EXPECT_NEAR(normalised, dense(static_cast<Eigen::Index>(6 * i + k)), 1e-10 * largest);
      }
    }
  }
}

TEST(FitSplineTest, ReproducesASineFromTwentyThousandPointsOneMillisecondApart) {
  constexpr std::size_t kPoints = 20'001;
  constexpr double kRate = 2;  // rad/s
  std::vector<Waypoint> waypoints(kPoints);
  std::vector<Duration> knots(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) {
    knots[i] = static_cast<std::int64_t>(i) * kCycle;
    waypoints[i].q[2] = std::sin(kRate * ToSeconds(knots[i]));
  }
  const auto segments = FitSpline(waypoints, knots);
  // The angle, up to 40 rad, is rounded by half of 7e-15: so far the points are off a true sine,
  // and each derivative divides that by 1 ms once more.
  constexpr double kRounding = 5e-15;
  constexpr double kSpacing = 1e-3;
  // The forced rest at the ends is felt over a few points only.
  for (std::size_t i = 100; i + 100 < segments.size(); i += 37) {
    const double angle = kRate * (ToSeconds(knots[i]) + 0.3e-3);
    const Derivatives d = At(segments[i], 2, 0.3e-3);
    EXPECT_NEAR(d[0], std::sin(angle), 3 * kRounding);
    EXPECT_NEAR(d[1], kRate * std::cos(angle), 10 * kRounding / kSpacing);
    EXPECT_NEAR(d[2], -std::pow(kRate, 2) * std::sin(angle),
                10 * kRounding / std::pow(kSpacing, 2));
    EXPECT_NEAR(d[3], -std::pow(kRate, 3) * std::cos(angle),
                50 * kRounding / std::pow(kSpacing, 3));
  }
}

}  // namespace
}  // namespace twin::reference::internal::quintic_spline_test
