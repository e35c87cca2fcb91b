#include "twin/reference/reference_generator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gmock/gmock.h>

#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/core/time.h"

namespace twin::reference::joint_reference_generator_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

JointVector Filled(double value) {
  JointVector v;
  v.fill(value);
  return v;
}

TEST(JointReferenceGeneratorTest, RefusesLambdaOutOfRange) {
  for (const double lambda : {0.0, -1e-3, 1.0001}) {
    EXPECT_THAT([&] { JointReferenceGenerator generator(lambda); },
                ThrowsMessage<InputError>(HasSubstr("it must lie in (0, 1]")));
  }
  EXPECT_THAT([] { JointReferenceGenerator generator(std::nan("")); },
              ThrowsMessage<InputError>(HasSubstr("lambda is nan")));
}

TEST(JointReferenceGeneratorTest, UsesThePapersLambdaByDefault) {
  EXPECT_EQ(JointReferenceGenerator().lambda(), 1e-3);
}

TEST(JointReferenceGeneratorTest, DecaysToAStalledTargetByOneMinusLambdaPerCycle) {
  for (const double lambda : {1e-3, 0.1}) {
    const JointReferenceGenerator generator(lambda);
    const JointTarget target{.q = {1, -1, 0.5, -2, 0.3, 2, -0.7}};
    JointVector q_d{};
    for (int k = 1; k <= 5000; ++k) {
      q_d = generator.Next(q_d, target);
      for (std::size_t j = 0; j < kJoints; ++j) {
        ASSERT_NEAR(target.q[j] - q_d[j], target.q[j] * std::pow(1 - lambda, k), 1e-12)
            << "cycle " << k;
      }
    }
  }
}

TEST(JointReferenceGeneratorTest, TakesTheWholeErrorAtLambdaOne) {
  const JointVector q_s =
      JointReferenceGenerator(1).Next(Filled(0.25), {.q = Filled(0.5), .dq = Filled(2)});
  for (const double q : q_s) EXPECT_DOUBLE_EQ(q, 0.502);
}

TEST(JointReferenceGeneratorTest, FollowsAConstantVelocityExactly) {
  const JointReferenceGenerator generator;
  JointVector q_d = Filled(0.125);
  for (int k = 1; k <= 2000; ++k) {
    // A target sampled at the cycle the state belongs to, with the source's own velocity.
    const double q_ext = 0.125 + 0.8e-3 * (k - 1);
    q_d = generator.Next(q_d, {.q = Filled(q_ext), .dq = Filled(0.8)});
    for (const double q : q_d) ASSERT_NEAR(q, 0.125 + 0.8e-3 * k, 1e-12);
  }
}

TEST(JointReferenceGeneratorTest, JitterOfTheTargetReachesTheJerkOnlyTimesLambda) {
  // 4 us of sampling jitter at 1 rad/s: forwarded as it is, the jerk would be of the order of
  // 1e4 rad/s^3; behind the generator it is lambda times that at most.
  constexpr double kLambda = 1e-3;
  const JointReferenceGenerator generator(kLambda);
  const Random random(1, RandomStream::kTest);
  JointVector q_d{};
  std::array<double, 4> history{};
  double worst_raw = 0;
  double worst = 0;
  std::array<double, 4> raw{};
  for (int k = 0; k < 5000; ++k) {
    const double jitter_s = 4e-6 * random.Normal(static_cast<std::uint64_t>(k));
    const double q_ext = 1.0 * (k * kCycleSeconds + jitter_s);
    q_d = generator.Next(q_d, {.q = Filled(q_ext), .dq = Filled(1.0)});
    raw = {q_ext, raw[0], raw[1], raw[2]};
    history = {q_d[0], history[0], history[1], history[2]};
    if (k < 4) continue;
    const auto jerk = [](const std::array<double, 4>& x) {
      return std::abs(x[0] - 3 * x[1] + 3 * x[2] - x[3]) / 1e-9;
    };
    worst_raw = std::max(worst_raw, jerk(raw));
    worst = std::max(worst, jerk(history));
  }
  EXPECT_GT(worst_raw, 1e4);
  EXPECT_LT(worst, 1.1 * kLambda * worst_raw);
}

}  // namespace
}  // namespace twin::reference::joint_reference_generator_test
