#include "twin/reference/reference_generator.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/reference/feed_forward.h"

namespace twin::reference::reference_cartesian_reference_generator_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kT = 1e-3;

/// Pose at time t of a screw with constant twist [v; w] from `start`.
Transform Screw(const Transform& start, const Vector3d& v, const Vector3d& w, double t) {
  Transform X = PoseOf(t * w, PositionOf(start) + t * v);
  Eigen::Map<Eigen::Matrix4d> matrix(X.data());
  matrix.topLeftCorner<3, 3>() = RotationOf(X) * RotationOf(start);
  return X;
}

TEST(CartesianReferenceGeneratorTest, RefusesLambdaOutOfRange) {
  for (const double lambda : {0.0, -1e-3, 1.0001, std::nan("")}) {
    EXPECT_THAT([&] { CartesianReferenceGenerator generator(lambda); },
                ThrowsMessage<InputError>(HasSubstr("Cartesian reference generator: lambda is")));
  }
  EXPECT_EQ(CartesianReferenceGenerator().lambda(), 1e-3);
}

TEST(CartesianReferenceGeneratorTest, DecaysToAStalledPoseByOneMinusLambdaPerCycle) {
  for (const double lambda : {1e-3, 0.1}) {
    const CartesianReferenceGenerator generator(lambda);
    const PoseTarget target{.O_T_EE = PoseOf({0.3, -1.9, 1.2}, {0.4, 0.1, 0.6})};
    const Transform start = PoseOf({-0.2, 0.4, 0.1}, {0.3, -0.3, 0.2});
    const Vector3d turn = RotationVector(start, target.O_T_EE);
    const Vector3d way = PositionOf(target.O_T_EE) - PositionOf(start);
    Transform X = start;
    for (int k = 1; k <= 5000; ++k) {
      X = generator.Next(X, target);
      const double left = std::pow(1 - lambda, k);
      ASSERT_LT((RotationVector(X, target.O_T_EE) - left * turn).norm(), 1e-12) << "cycle " << k;
      ASSERT_LT((PositionOf(target.O_T_EE) - PositionOf(X) - left * way).norm(), 1e-12)
          << "cycle " << k;
    }
  }
}

TEST(CartesianReferenceGeneratorTest, TakesTheWholeErrorAndAPeriodOfTheTwistAtLambdaOne) {
  const Random random(1, RandomStream::kTest);
  const CartesianReferenceGenerator generator(1);
  for (std::uint64_t k = 0; k < 200; ++k) {
    const Transform X_ext = RandomPose(random, 2 * k);
    const Transform X =
        generator.Next(RandomPose(random, 2 * k + 1), {X_ext, {0.5, -1, 2, 0, 0, 0}});
    EXPECT_LT((RotationOf(X) - RotationOf(X_ext)).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT((PositionOf(X) - PositionOf(X_ext) - kT * Vector3d(0.5, -1, 2)).norm(), 1e-14);
  }
}

TEST(CartesianReferenceGeneratorTest, FollowsAConstantTwistExactly) {
  // Some six turns about an axis of no frame.
  const Vector3d v(0.05, -0.04, 0.02);
  const Vector3d w(1.1, -0.7, 1.4);
  const Transform start = PoseOf({0.2, 0.5, -0.1}, {0.3, 0.2, 0.5});
  const CartesianReferenceGenerator generator;
  Transform X = start;
  for (int k = 1; k <= 20'000; ++k) {
    const PoseTarget target{Screw(start, v, w, (k - 1) * kT), {v[0], v[1], v[2], w[0], w[1], w[2]}};
    X = generator.Next(X, target);
    const Transform expected = Screw(start, v, w, k * kT);
    for (std::size_t i = 0; i < X.size(); ++i) ASSERT_NEAR(X[i], expected[i], 1e-12) << k;
  }
}

TEST(CartesianReferenceGeneratorTest, StaysOrthonormalOverAMillionCycles) {
  const Random random(2, RandomStream::kTest);
  const CartesianReferenceGenerator generator(0.01);
  Transform X = kIdentityTransform;
  PoseTarget target;
  double worst = 0;
  for (std::uint64_t k = 0; k < 1'000'000; ++k) {
    if (k % 100 == 0) {
      target.O_T_EE = RandomPose(random, k);
      const Vector3d w = 2.5 * RandomVector(random, k, 10);
      target.O_dP_EE = {0.1, 0, -0.1, w[0], w[1], w[2]};
    }
    X = generator.Next(X, target);
    worst = std::max(worst, Obliqueness(X));
  }
  EXPECT_LT(worst, 1e-12);
  EXPECT_EQ((std::array{X[3], X[7], X[11], X[15]}), (std::array{0.0, 0.0, 0.0, 1.0}));
}

TEST(CartesianReferenceGeneratorTest, StraightensAnObliquePoseOfTheState) {
  Transform oblique = PoseOf({0.3, 0.1, 0.2}, {0, 0, 0});
  for (std::size_t i = 0; i < 3; ++i) oblique[i] *= 1 + 5e-6;
  const Transform X =
      CartesianReferenceGenerator().Next(oblique, {PoseOf({0.4, 0, 0}, {0, 0, 0}), {}});
  EXPECT_LT(Obliqueness(X), 1e-14);
}

TEST(CartesianReferenceGeneratorTest, ComesToRestExactly) {
  const Random random(3, RandomStream::kTest);
  for (const double lambda : {1e-3, 0.05, 0.5, 1.0}) {
    const CartesianReferenceGenerator generator(lambda);
    for (std::uint64_t i = 0; i < 5; ++i) {
      const PoseTarget target{RandomPose(random, 2 * i), {}};
      Transform X = RandomPose(random, 2 * i + 1);
      const auto cycles = static_cast<int>(60 / lambda);
      for (int k = 0; k < cycles; ++k) X = generator.Next(X, target);
      EXPECT_EQ(generator.Next(X, target), X) << "lambda " << lambda;
      EXPECT_LT(RotationVector(X, target.O_T_EE).norm(), 1e-14 / lambda + 1e-15);
      EXPECT_LT((PositionOf(X) - PositionOf(target.O_T_EE)).norm(), 1e-15 / lambda + 1e-15);
    }
  }
}

/// Largest third difference over T^3 of translation and rotation.
struct PoseJerk {
  Transform last = kIdentityTransform;
  Vector3d v = Vector3d::Zero(), w = Vector3d::Zero();
  Vector3d a = Vector3d::Zero(), alpha = Vector3d::Zero();
  double translation = 0;
  double rotation = 0;

  void Take(const Transform& X, bool counts) {
    const Vector3d v_next = (PositionOf(X) - PositionOf(last)) / kT;
    const Vector3d w_next = RotationVector(last, X) / kT;
    const Vector3d a_next = (v_next - v) / kT;
    const Vector3d alpha_next = (w_next - w) / kT;
    if (counts) {
      translation = std::max(translation, ((a_next - a) / kT).norm());
      rotation = std::max(rotation, ((alpha_next - alpha) / kT).norm());
    }
    last = X;
    v = v_next;
    w = w_next;
    a = a_next;
    alpha = alpha_next;
  }
};

TEST(CartesianReferenceGeneratorTest, SamplingJitterReachesTheJerkOnlyInSmallPart) {
  // Poses sampled with 4 us of jitter, their twist formed at the deposit over the source's own
  // time.
  const Vector3d v(0.5, 0, 0);
  const Vector3d w(0, 0.8, 0.6);
  const Random random(4, RandomStream::kTest);
  const CartesianReferenceGenerator generator;
  PoseFeedForward feed_forward;
  Transform X = kIdentityTransform;
  PoseJerk raw;
  PoseJerk generated;
  for (int k = 0; k < 5000; ++k) {
    const double jitter_s = 4e-6 * random.Normal(static_cast<std::uint64_t>(k));
    const Time at(FromSeconds(k * kT + jitter_s));
    const Transform X_ext = Screw(kIdentityTransform, v, w, ToSeconds(at.time_since_epoch()));
    X = generator.Next(X, feed_forward.Next(at, X_ext));
    raw.Take(X_ext, k > 4);
    generated.Take(X, k > 4);
  }
  EXPECT_GT(raw.translation, 6500);
  EXPECT_GT(raw.rotation, 12500);
  EXPECT_LT(generated.translation, 2e-3 * raw.translation);
  EXPECT_LT(generated.rotation, 2e-3 * raw.rotation);
}

TEST(CartesianReferenceGeneratorTest, AllocatesNothing) {
  const Random random(5, RandomStream::kTest);
  const CartesianReferenceGenerator generator;
  Transform X = kIdentityTransform;
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    X = generator.Next(X, {RandomPose(random, k), {0, 0, 1, 0, 1, 0}});
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(X, kIdentityTransform);
}

}  // namespace
}  // namespace twin::reference::reference_cartesian_reference_generator_test
