#include "twin/reference/low_pass.h"

#include <cmath>

#include <gmock/gmock.h>
#include <Eigen/Geometry>

#include "reference/reference_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::reference::reference_low_pass_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(LowPassTest, GainIsLibfrankas) {
  EXPECT_NEAR(LowPass(100).gain(), 0.385870, 5e-7);
  // 2 pi f T / (1 + 2 pi f T), by hand.
  EXPECT_NEAR(LowPass(1).gain(), 0.00624395, 5e-9);
  EXPECT_NEAR(LowPass(500).gain(), 0.758547, 5e-7);
}

TEST(LowPassTest, RefusesACutOffOutOfRange) {
  for (const double cutoff : {0.0, 0.999, -100.0, 1000.001, std::nan("")}) {
    EXPECT_THAT([&] { LowPass filter(cutoff); },
                ThrowsMessage<InputError>(HasSubstr("it must lie in [1, 1000]")));
  }
}

TEST(LowPassTest, GivesTheInputExactlyWhenOff) {
  const LowPass off(1000);
  EXPECT_FALSE(off.is_on());
  EXPECT_TRUE(LowPass(999.9).is_on());
  const Random random(1, RandomStream::kTest);
  Transform oblique = RandomPose(random, 0);
  oblique[0] += 1e-7;
  const JointVector q{0.1, 0.2, 0.3, -0.4, 0.5, 0.6, 0.7};
  EXPECT_EQ(off.Filter(q, Filled(3)), q);
  EXPECT_EQ(off.Filter(0.1, 3.0), 0.1);
  EXPECT_EQ(off.FilterPose(oblique, RandomPose(random, 1)), oblique);
}

TEST(LowPassTest, MixesInputAndLastValueByTheGain) {
  const Random random(2, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 200; ++k) {
    const LowPass filter(1 + 998 * random.Uniform(k));
    const Vector6 x{random.Normal(k, 1), random.Normal(k, 2), 0, 1, random.Normal(k, 3), -1};
    const Vector6 last{random.Normal(k, 4), random.Normal(k, 5), 1, 1, random.Normal(k, 6), 0};
    const Vector6 y = filter.Filter(x, last);
    for (std::size_t i = 0; i < x.size(); ++i) {
      EXPECT_NEAR(y[i], filter.gain() * x[i] + (1 - filter.gain()) * last[i], 1e-15);
    }
  }
}

TEST(LowPassTest, AnswersAStepByOneMinusAPower) {
  for (const double cutoff : {1.0, 10.0, 100.0, 500.0}) {
    const LowPass filter(cutoff);
    JointVector y{};
    for (int k = 1; k <= 500; ++k) {
      y = filter.Filter(Filled(2), y);
      for (const double value : y) {
        ASSERT_NEAR(value, 2 * (1 - std::pow(1 - filter.gain(), k)), 1e-13);
      }
    }
  }
}

TEST(LowPassTest, LeavesWhatIsStillStill) {
  const Random random(3, RandomStream::kTest);
  const LowPass filter(100);
  for (std::uint64_t k = 0; k < 100; ++k) {
    const JointVector q = Filled(random.Normal(k));
    EXPECT_EQ(filter.Filter(q, q), q);
    const Transform X = RandomPose(random, k);
    EXPECT_EQ(filter.FilterPose(X, X), X);
  }
}

TEST(LowPassTest, InterpolatesARotationSphericallyAndATranslationLinearly) {
  const Random random(4, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 500; ++k) {
    const LowPass filter(1 + 998 * random.Uniform(k, 20));
    const Transform x = RandomPose(random, 2 * k);
    const Transform last = RandomPose(random, 2 * k + 1);
    const Transform y = filter.FilterPose(x, last);
    const Eigen::Quaterniond slerp = Eigen::Quaterniond(RotationOf(last))
                                         .slerp(filter.gain(), Eigen::Quaterniond(RotationOf(x)));
    EXPECT_LT((RotationOf(y) - slerp.toRotationMatrix()).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::Vector3d p =
        filter.gain() * PositionOf(x) + (1 - filter.gain()) * PositionOf(last);
    EXPECT_LT((PositionOf(y) - p).norm(), 1e-14);
    EXPECT_EQ((std::array{y[3], y[7], y[11], y[15]}), (std::array{0.0, 0.0, 0.0, 1.0}));
  }
}

TEST(LowPassTest, KeepsAPoseOrthonormalHoweverLongItRuns) {
  const Random random(5, RandomStream::kTest);
  const LowPass filter(30);
  Transform y = RandomPose(random, 0);
  for (std::uint64_t k = 1; k <= 100'000; ++k) {
    y = filter.FilterPose(RandomPose(random, k / 50), y);
    ASSERT_LT(Obliqueness(y), 1e-14);
  }
}

TEST(LowPassTest, AllocatesNothing) {
  const Random random(6, RandomStream::kTest);
  const LowPass filter(100);
  Transform y = kIdentityTransform;
  JointVector q{};
  const test::RealtimeGuard guard;
  for (std::uint64_t k = 0; k < 10'000; ++k) {
    y = filter.FilterPose(RandomPose(random, k), y);
    q = filter.Filter(Filled(random.Uniform(k)), q);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(q[0], y[0]);
}

}  // namespace
}  // namespace twin::reference::reference_low_pass_test
