// What the paper states about rate matching, reference generation and the low-pass, measured on the
// pieces put together: source -> feed-forward -> rate matcher -> reference generator -> low-pass.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "reference/reference_samples.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/time.h"
#include "twin/reference/feed_forward.h"
#include "twin/reference/low_pass.h"
#include "twin/reference/rate_matcher.h"
#include "twin/reference/reference_generator.h"

namespace twin::reference::reference_chain_test {
namespace {

constexpr double kT = kCycleSeconds;
constexpr double kLambda = 1e-3;

/// Third difference over T^3 of a sequence of joint positions.
class JerkMeter {
 public:
  void Take(const JointVector& q) {
    last_ = {q, last_[0], last_[1], last_[2]};
    ++count_;
  }
  /// @returns rad/s^3, of the last four positions.
  [[nodiscard]] double Jerk(std::size_t joint) const {
    return (last_[0][joint] - 3 * last_[1][joint] + 3 * last_[2][joint] - last_[3][joint]) /
           (kT * kT * kT);
  }
  [[nodiscard]] int count() const { return count_; }

 private:
  std::array<JointVector, 4> last_{};
  int count_ = 0;
};

/// All joints swing sin(kOmega t), each with `share` of its acceleration limit at the ends.
struct Swing {
  static constexpr double kOmega = 4;
  double share;

  [[nodiscard]] double PeakAcceleration(std::size_t joint) const {
    return share * test::PandaLimits().ddq_max[joint];
  }
  [[nodiscard]] double PeakJerk(std::size_t joint) const {
    return kOmega * PeakAcceleration(joint);
  }
  [[nodiscard]] JointTarget At(double t) const {
    JointTarget target;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double a = PeakAcceleration(j);
      target.q[j] = a / (kOmega * kOmega) * std::sin(kOmega * t);
      target.dq[j] = a / kOmega * std::cos(kOmega * t);
    }
    return target;
  }
};

/// All joints move steadily.
struct Line {
  double velocity;

  [[nodiscard]] JointTarget At(double t) const {
    return {.q = Filled(velocity * t), .dq = Filled(velocity), .ddq = {}};
  }
};

enum class Matching { kPositionOnly, kAll };
enum class Velocity { kOfTheSource, kFormedAtTheDeposit };

/// Largest jerk of each joint over 60 s of a source at 125 Hz of its own clock, `ppm` fast, with a
/// reference generator behind.
template <typename Motion>
JointVector LargestJerk(const Motion& motion, double ppm, Matching matching, Velocity velocity) {
  const double period = 8 * kT / (1 + ppm * 1e-6);
  RateMatcher matcher(125);
  FeedForward feed_forward;
  const JointReferenceGenerator generator(kLambda);
  JointVector q_d = motion.At(0).q;
  matcher.Reset(motion.At(0));
  JerkMeter meter;
  JointVector largest{};
  JointTarget deposit;
  int deposits = 0;
  for (int k = 0; k < 60'000; ++k) {
    // A hair late, so that rounding does not decide whether a deposit is in time.
    for (; deposits * period <= (k + 1e-3) * kT; ++deposits) {
      const double t = deposits * period;
      deposit = motion.At(t);
      const JointTarget formed = feed_forward.Next(Time(FromSeconds(t)), deposit.q);
      if (velocity == Velocity::kFormedAtTheDeposit) deposit = formed;
    }
    JointTarget matched = matcher.Next(deposit);
    if (matching == Matching::kPositionOnly) matched.dq = deposit.dq;
    q_d = generator.Next(q_d, matched);
    meter.Take(q_d);
    if (meter.count() < 100) continue;
    for (std::size_t j = 0; j < kJoints; ++j) {
      largest[j] = std::max(largest[j], std::abs(meter.Jerk(j)));
    }
  }
  return largest;
}

/// What an update of 7 or 9 cycles brings, its ramp having one cycle of double or no increment: a
/// cycle of no acceleration, ddq/T, and lambda times an increment of position, lambda dq/T^2; the
/// most that both make together on this swing.
double SlipJerk(const Swing& swing, std::size_t joint) {
  return swing.PeakAcceleration(joint) / kT * std::hypot(1, kLambda / (Swing::kOmega * kT));
}

/// What a ramp's corners bring: the source's own jerk over 8 cycles in one, and lambda times the
/// corners of the averaged position.
double CornerJerk(const Swing& swing, std::size_t joint) {
  return 8 * swing.PeakJerk(joint) + 8 * kLambda * swing.PeakAcceleration(joint) / kT;
}

TEST(ReferenceChainTest, RateMatchingAddsNoJerkWhenTheClocksAgree) {
  for (const auto velocity : {Velocity::kOfTheSource, Velocity::kFormedAtTheDeposit}) {
    for (const double share : {0.1, 0.4, 0.9}) {
      const Swing swing{share};
      const JointVector jerk = LargestJerk(swing, 0, Matching::kAll, velocity);
      for (std::size_t j = 0; j < kJoints; ++j) {
        EXPECT_LE(jerk[j], 1.01 * CornerJerk(swing, j)) << "joint " << j + 1;
        EXPECT_GT(jerk[j], 0.5 * CornerJerk(swing, j)) << "joint " << j + 1;
        EXPECT_LT(jerk[j], 0.1 * test::PandaLimits().dddq_max[j]) << "joint " << j + 1;
      }
    }
  }
}

TEST(ReferenceChainTest, RateMatchingStaysWithinTheJerkLimitUnderDrift) {
  // 0.4 of the acceleration limit a cycle is 0.8 of the Panda's jerk limit.
  const Swing swing{0.4};
  for (const auto velocity : {Velocity::kOfTheSource, Velocity::kFormedAtTheDeposit}) {
    for (const double ppm : {-1000.0, -300.0, 300.0, 1000.0}) {
      const JointVector jerk = LargestJerk(swing, ppm, Matching::kAll, velocity);
      for (std::size_t j = 0; j < kJoints; ++j) {
        const double slip = SlipJerk(swing, j);
        EXPECT_LT(jerk[j], test::PandaLimits().dddq_max[j]) << ppm << " ppm, joint " << j + 1;
        EXPECT_LE(jerk[j], 1.01 * (slip + CornerJerk(swing, j))) << ppm << " ppm, joint " << j + 1;
        EXPECT_GT(jerk[j], 0.8 * slip) << ppm << " ppm: no update slipped, joint " << j + 1;
      }
    }
  }
}

TEST(ReferenceChainTest, UnderDriftThePromiseEndsAtHalfTheAccelerationLimit) {
  const JointVector jerk =
      LargestJerk(Swing{0.6}, 1000, Matching::kAll, Velocity::kFormedAtTheDeposit);
  for (std::size_t j = 0; j < kJoints; ++j) EXPECT_GT(jerk[j], test::PandaLimits().dddq_max[j]);
}

TEST(ReferenceChainTest, UnderDriftASteadyMotionBringsLambdaTimesItsVelocity) {
  for (const double velocity : {0.5, 2.0}) {
    const JointVector jerk =
        LargestJerk(Line{velocity}, -300, Matching::kAll, Velocity::kFormedAtTheDeposit);
    EXPECT_NEAR(jerk[0] / (kLambda * velocity / (kT * kT)), 1, 0.01);
  }
}

TEST(ReferenceChainTest, WithThePositionAloneAveragedTheJerkIsEightAccelerationsACycle) {
  const Swing swing{0.2};
  for (const auto velocity : {Velocity::kOfTheSource, Velocity::kFormedAtTheDeposit}) {
    const JointVector jerk = LargestJerk(swing, 0, Matching::kPositionOnly, velocity);
    for (std::size_t j = 0; j < kJoints; ++j) {
      EXPECT_NEAR(jerk[j] / (8 * swing.PeakAcceleration(j) / kT), 1, 0.01) << "joint " << j + 1;
      EXPECT_GT(jerk[j], 3 * test::PandaLimits().dddq_max[j]) << "joint " << j + 1;
    }
  }
}

TEST(ReferenceChainTest, ADepositTakenTwiceBesideASkippedOneMakesTwoSlips) {
  // Constant acceleration, one deposit a cycle with the source's own velocity; in cycle 500 the
  // last one once more.
  constexpr double kAcceleration = 3;
  const JointReferenceGenerator generator(kLambda);
  JointVector q_d{};
  JerkMeter meter;
  double largest = 0;
  for (int k = 0; k < 600; ++k) {
    const double t = (k == 500 ? k - 1 : k) * kT;
    q_d = generator.Next(q_d,
                         {.q = Filled(kAcceleration * t * t / 2), .dq = Filled(kAcceleration * t)});
    meter.Take(q_d);
    if (meter.count() > 100) largest = std::max(largest, std::abs(meter.Jerk(0)));
  }
  // 2 ddq/T, and 2 lambda dq/T^2 of the position.
  const double velocity = kAcceleration * 500 * kT;
  EXPECT_NEAR(largest, 2 * kAcceleration / kT + 2 * kLambda * velocity / (kT * kT), 0.01 * largest);
}

/// Largest jerk of joint 1 at 1 rad/s with one sample 4 us late: of the samples, and behind the
/// reference generator with the velocity formed over this time.
struct DisplacedSample {
  double raw = 0;
  double generated = 0;
};

DisplacedSample DisplaceASample(FeedForwardTime time) {
  FeedForward feed_forward(time);
  const JointReferenceGenerator generator(kLambda);
  JointVector q_d{};
  JerkMeter raw;
  JerkMeter generated;
  DisplacedSample largest;
  for (int k = 0; k < 1000; ++k) {
    const Duration late = std::chrono::microseconds(k == 500 ? 4 : 0);
    const Time at(k * kCycle + late);
    const JointVector q_ext = Filled(ToSeconds(at.time_since_epoch()));
    q_d = generator.Next(q_d, feed_forward.Next(at, q_ext));
    raw.Take(q_ext);
    generated.Take(q_d);
    if (k < 100) continue;
    largest.raw = std::max(largest.raw, std::abs(raw.Jerk(0)));
    largest.generated = std::max(largest.generated, std::abs(generated.Jerk(0)));
  }
  return largest;
}

TEST(ReferenceChainTest, ASampleFourMicrosecondsOffBreaksTheJerkLimitOfEveryJoint) {
  // The third difference of one displaced sample is 1, -3, 3, -1 times 4 urad.
  const double jerk = DisplaceASample(FeedForwardTime::kSource).raw;
  EXPECT_NEAR(jerk, 1.2e4, 0.01 * 1.2e4);
  for (const double limit : test::PandaLimits().dddq_max) EXPECT_GT(jerk, limit);
}

TEST(ReferenceChainTest, BehindTheGeneratorADisplacedSampleLeavesLambdaOfIt) {
  // lambda times 1, -2, 1 times 4 urad.
  EXPECT_NEAR(DisplaceASample(FeedForwardTime::kSource).generated, 2 * kLambda * 4e-6 / 1e-9, 0.1);
}

TEST(ReferenceChainTest, WithTheNominalTimeADisplacedSamplePassesWhole) {
  EXPECT_NEAR(DisplaceASample(FeedForwardTime::kNominal).generated, 1.2e4, 0.01 * 1.2e4);
}

/// RMS over a long run: white noise on q_ext at standstill, against what comes out of the
/// generator.
struct NoiseRatio {
  double position = 0;
  double jerk = 0;
};

NoiseRatio MeasureNoise(double lambda, Velocity velocity) {
  constexpr double kSigma = 1e-5;
  const Random random(1, RandomStream::kTest);
  const JointReferenceGenerator generator(lambda);
  FeedForward feed_forward;
  JointVector q_d{};
  JerkMeter raw;
  JerkMeter generated;
  std::array<double, 4> sums{};
  for (int k = 0; k < 200'000; ++k) {
    const JointVector q_ext = Filled(kSigma * random.Normal(static_cast<std::uint64_t>(k)));
    JointTarget target = feed_forward.Next(Time(k * kCycle), q_ext);
    if (velocity == Velocity::kOfTheSource) target.dq = {};
    q_d = generator.Next(q_d, target);
    raw.Take(q_ext);
    generated.Take(q_d);
    if (k < 10'000) continue;
    sums[0] += q_ext[0] * q_ext[0];
    sums[1] += q_d[0] * q_d[0];
    sums[2] += raw.Jerk(0) * raw.Jerk(0);
    sums[3] += generated.Jerk(0) * generated.Jerk(0);
  }
  return {std::sqrt(sums[1] / sums[0]), std::sqrt(sums[3] / sums[2])};
}

TEST(ReferenceChainTest, WhiteNoiseOfTheTargetIsScaledByLambdaWhenTheSourceGivesItsVelocity) {
  for (const double lambda : {1e-3, 1e-2}) {
    const NoiseRatio ratio = MeasureNoise(lambda, Velocity::kOfTheSource);
    // The third difference of the noise, 1 -3 3 -1, becomes lambda times its second, 1 -2 1.
    EXPECT_NEAR(ratio.jerk / (lambda * std::sqrt(6.0 / 20)), 1, 0.02) << "lambda " << lambda;
    // A first-order lag's share of white noise.
    EXPECT_NEAR(ratio.position / std::sqrt(lambda / (2 - lambda)), 1, 0.15) << "lambda " << lambda;
  }
}

TEST(ReferenceChainTest, WhiteNoiseOfTheTargetComesOutWholeWhenTheVelocityIsFormedFromIt) {
  const NoiseRatio ratio = MeasureNoise(kLambda, Velocity::kFormedAtTheDeposit);
  EXPECT_NEAR(ratio.jerk, 1, 0.01);
}

/// How much of a sinusoid of angular frequency omega the generator follows with a low-pass behind
/// it: the amplitude over ten periods once it has settled.
double MeasuredGain(double omega, const LowPass& low_pass) {
  const JointReferenceGenerator generator(kLambda);
  const auto settle = static_cast<int>(40 / kT);
  const auto end = settle + static_cast<int>(std::lround(10 * 2 * std::numbers::pi / omega / kT));
  JointVector q_d{};
  double in_phase = 0;
  double quadrature = 0;
  for (int k = 0; k < end; ++k) {
    const double t = k * kT;
    const JointTarget target{.q = Filled(std::sin(omega * t)),
                             .dq = Filled(omega * std::cos(omega * t))};
    q_d = low_pass.Filter(generator.Next(q_d, target), q_d);
    if (k < settle) continue;
    in_phase += q_d[0] * std::sin(omega * t);
    quadrature += q_d[0] * std::cos(omega * t);
  }
  return 2 * std::hypot(in_phase, quadrature) / (end - settle);
}

TEST(ReferenceChainTest, ALowPassBehindTheGeneratorFollowsAFractionOfTheMotion) {
  for (const double cutoff : {30.0, 100.0}) {
    const LowPass low_pass(cutoff);
    const double g = low_pass.gain();
    for (const double omega : {0.3, 1.0, 2.0, 5.0, 20.0}) {
      // |g (s + lambda/T) / (s + g lambda/T)| at s = i omega.
      const double analytic =
          g * std::hypot(omega, kLambda / kT) / std::hypot(omega, g * kLambda / kT);
      EXPECT_NEAR(MeasuredGain(omega, low_pass) / analytic, 1, 5e-3)
          << cutoff << " Hz, " << omega << " rad/s";
    }
  }
}

TEST(ReferenceChainTest, AtLibfrankasCutOffItIsFourToFiveTenths) {
  const LowPass low_pass(100);
  for (const double period_s : {2.0, 3.0, 6.0}) {
    const double gain = MeasuredGain(2 * std::numbers::pi / period_s, low_pass);
    EXPECT_GT(gain, 0.395) << period_s << " s";
    EXPECT_LT(gain, 0.505) << period_s << " s";
  }
}

TEST(ReferenceChainTest, WithTheLowPassOffTheWholeMotionIsFollowed) {
  for (const double omega : {0.3, 2.0, 20.0}) {
    EXPECT_NEAR(MeasuredGain(omega, LowPass(1000)), 1, 1e-3) << omega << " rad/s";
  }
}

TEST(ReferenceChainTest, AllocatesNothing) {
  const Swing swing{0.3};
  FeedForward feed_forward;
  RateMatcher matcher(125);
  const JointReferenceGenerator generator(kLambda);
  const LowPass low_pass(100);
  JointVector q_d{};
  const test::RealtimeGuard guard;
  for (int k = 0; k < 10'000; ++k) {
    if (k % 5000 == 0) matcher.Reset({});
    const JointTarget deposit = feed_forward.Next(Time(k * kCycle), swing.At(k * kT).q);
    q_d = low_pass.Filter(generator.Next(q_d, matcher.Next(deposit)), q_d);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
  EXPECT_NE(q_d, JointVector{});
}

}  // namespace
}  // namespace twin::reference::reference_chain_test
