#include "twin/reference/resampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/transform.h"

namespace twin::reference::reference_resampler_test {
namespace {

constexpr double kT = kCycleSeconds;

/// A source that samples joint 1's motion at its own instants, and a robot that plays it.
class Playing {
 public:
  explicit Playing(double rate_hz) : resampler_(rate_hz), period_s_(1 / rate_hz) {}

  double (*motion)(double t) = [](double t) { return 0.3 * std::sin(2 * t); };
  double jitter_s = 0;    ///< standard deviation of the sampling instants
  double drift = 0;       ///< of the source's clock
  double phase_s = 4e-4;  ///< of its first sample, against the robot's cycles
  double lost_share = 0;  ///< of the deposits

  /// @returns what is played, cycle by cycle.
  std::vector<double> Run(int cycles) {
    JointVector q{};
    q[0] = motion(0);
    resampler_.Reset(q);
    const Random random(5, RandomStream::kTest);
    std::vector<double> played;
    double next = phase_s;
    std::uint64_t draw = 0;
    for (int k = 1; k <= cycles; ++k) {
      while (next <= k * kT) {
        const double at = next + jitter_s * random.Normal(++draw);
        if (random.Uniform(++draw) >= lost_share) {
          q[0] = motion(at);
          resampler_.Deposit(SourceTime(at), q);
        }
        next += period_s_ / (1 + drift);
      }
      resampler_.Advance();
      played.push_back(resampler_.Value()[0]);
    }
    return played;
  }

  [[nodiscard]] const Resampler& resampler() const { return resampler_; }

 private:
  [[nodiscard]] Time SourceTime(double t) const {
    return Time(std::chrono::seconds(100)) + Duration(std::llround(t * (1 + drift) * 1e9));
  }

  Resampler resampler_;
  double period_s_;
};

double MostJerk(const std::vector<double>& q, std::size_t from) {
  double most = 0;
  for (std::size_t k = from; k < q.size(); ++k) {
    most = std::max(most, std::abs(q[k] - 3 * q[k - 1] + 3 * q[k - 2] - q[k - 3]) / (kT * kT * kT));
  }
  return most;
}

TEST(ResamplerTest, PlaysAnEvenSourceLateAndNoMore) {
  for (const double rate : {50.0, 100.0, 333.0, 1000.0}) {
    Playing playing(rate);
    const std::vector<double> played = playing.Run(4000);
    // The lag, and what the first sample's phase and the cycle of its arrival add.
    double best = 1;
    for (double lag = 0; lag < playing.resampler().lag_s() + 2e-3; lag += 1e-5) {
      double most = 0;
      for (std::size_t k = 1000; k < played.size(); k += 7) {
        const double t = static_cast<double>(k + 1) * kT;
        most = std::max(most, std::abs(played[k] - playing.motion(t - lag)));
      }
      best = std::min(best, most);
    }
    EXPECT_LT(best, 2.5e-5) << rate << " Hz";  // 40 us of play time at 0.6 rad/s
  }
}

TEST(ResamplerTest, SamplingJitterIsNoJerk) {
  Playing even(1000);
  Playing jittery(1000);
  jittery.jitter_s = 4e-6;
  const double base = MostJerk(even.Run(5000), 1000);
  const double jerk = MostJerk(jittery.Run(5000), 1000);
  // Raw, 4 us of jitter would be three differences of 0.6 rad/s * 4e-6 s: some 1e4 rad/s^3.
  EXPECT_LT(base, 5);
  EXPECT_LT(jerk, 20);
}

TEST(ResamplerTest, DepositsConsumedTwiceOrSkippedAreNoJerk) {
  for (const double drift : {100e-6, -100e-6}) {
    Playing playing(1000);
    playing.drift = drift;  // twice per 10 s a cycle has none, or two
    playing.phase_s = 1e-6;
    playing.jitter_s = 4e-6;
    EXPECT_LT(MostJerk(playing.Run(20000), 1000), 50) << drift;
  }
}

TEST(ResamplerTest, ADepositThatIsLostIsInterpolated) {
  Playing playing(1000);
  playing.lost_share = 0.02;
  const std::vector<double> played = playing.Run(5000);
  // Two in a row are among them. Raw, a gap is a step of 0.6 mrad: 6e5 rad/s^3.
  EXPECT_LT(MostJerk(played, 1000), 1500);
}

TEST(ResamplerTest, FollowsAClockThatDrifts) {
  Playing playing(1000);
  playing.drift = 500e-6;
  const std::vector<double> played = playing.Run(60000);
  // Behind the same instant by the lag after a minute, in which the clocks parted by 30 ms.
  const double t = 60000 * kT;
  double lag = 0;
  while (lag < 10e-3 && std::abs(played.back() - playing.motion(t - lag)) > 2e-6) lag += 1e-6;
  EXPECT_NEAR(lag, playing.resampler().lag_s(), 0.7e-3);
}

/// A resampler of 100 Hz, 300 ms into a motion of joint 4 at 1 rad/s.
Resampler AtSpeed() {
  Resampler resampler(100);
  JointVector q{};
  resampler.Reset(q);
  for (int i = 0; i < 30; ++i) {
    q[3] = 0.01 * i;
    resampler.Deposit(Time(std::chrono::milliseconds(1000 + 10 * i)), q);
    for (int k = 0; k < 10; ++k) resampler.Advance();
  }
  return resampler;
}

TEST(ResamplerTest, GoesOnWithTheMotionWhileDepositsFailToCome) {
  Resampler resampler = AtSpeed();
  const double before = resampler.Value()[3];
  for (int k = 0; k < 60; ++k) resampler.Advance();
  EXPECT_NEAR(resampler.Value()[3], before + 0.06, 1e-9);
}

TEST(ResamplerTest, ContinuesAConstantAcceleration) {
  Resampler resampler(1000);
  resampler.Reset({});
  const auto at = [](double t) { return JointVector{3 * t * t}; };
  for (int i = 0; i < 100; ++i) {
    resampler.Deposit(Time(std::chrono::milliseconds(i + 1)), at(1e-3 * i));
    resampler.Advance();
  }
  const double begin = resampler.Source()[0];
  EXPECT_NEAR(begin, at(100e-3)[0], 1e-6) << "when the command arrives";
  for (int k = 0; k < 12; ++k) resampler.Advance();
  EXPECT_NEAR(resampler.Source()[0], at(112e-3)[0], 1e-6);
}

TEST(ResamplerTest, StandsAtTheLastDepositOfASourceThatIsStopped) {
  Resampler resampler = AtSpeed();
  resampler.Stop();
  for (std::size_t cycles = 0; cycles < Resampler::kPlayed; ++cycles) {
    EXPECT_EQ(resampler.Value(cycles)[3], 0.29);
  }
}

TEST(ResamplerTest, BeginsAnewWithASourceThatReturns) {
  Resampler resampler = AtSpeed();
  resampler.Stop();
  resampler.Deposit(Time(std::chrono::seconds(9)), JointVector{});
  resampler.Advance();
  EXPECT_EQ(resampler.Value()[3], 0);
}

TEST(ResamplerTest, WhatALateDepositChangesItChangesOfThePastToo) {
  // The motion turned while no deposit came: what was played has gone on straight.
  Resampler resampler = AtSpeed();
  for (int k = 0; k < 30; ++k) resampler.Advance();
  const double straight = resampler.Value()[3];
  JointVector q{};
  q[3] = 0.20;
  resampler.Deposit(Time(std::chrono::milliseconds(1330)), q);
  EXPECT_LT(resampler.Value(0)[3], straight - 1e-3);
  const double step = (resampler.Value(0)[3] - resampler.Value(1)[3]) / kT;
  EXPECT_LT(std::abs(step), 20) << "rad/s: a velocity of the curve, not the step of what is known";
}

TEST(ResamplerTest, GoesOnWithASourceWhoseTimeJumped) {
  Resampler resampler(1000);
  JointVector q{};
  resampler.Reset(q);
  for (int i = 0; i < 400; ++i) {
    const int ms = i < 200 ? i : i + 5000;
    q[0] = 1e-3 * ms;
    resampler.Deposit(Time(std::chrono::milliseconds(1000 + ms)), q);
    resampler.Advance();
  }
  EXPECT_NEAR(resampler.Value()[0], q[0] - resampler.lag_s(), 2e-3);
}

TEST(ResamplerTest, FollowsASourceWhoseClockIsSetBack) {
  Resampler resampler = AtSpeed();
  JointVector q{};
  for (int i = 0; i < 20; ++i) {
    q[3] = -0.01 * i;
    resampler.Deposit(Time(std::chrono::milliseconds(100 + 10 * i)), q);
    for (int k = 0; k < 10; ++k) resampler.Advance();
  }
  EXPECT_NEAR(resampler.Value()[3], q[3] + resampler.lag_s(), 11e-3);
}

TEST(ResamplerTest, PlaysWhereTheMotionBeginsUntilADepositComes) {
  Resampler resampler(1000);
  JointVector q{};
  q.fill(0.5);
  resampler.Reset(q);
  EXPECT_EQ(resampler.Value(), q);
  resampler.Advance();
  EXPECT_EQ(resampler.Value(), q);
}

/// Plays 1 s of x = t (1 + noise) at 1 kHz. @returns the largest jerk of the values played in the
/// last half, and how far they end from the source.
struct Heard {
  double jerk = 0;
  double behind = 0;
};
Heard PlayWithNoise(Resampler& resampler, double noise) {
  Random random(1, RandomStream::kTargetNoise);
  Heard heard;
  resampler.Reset({});
  JointVector q{};
  for (int i = 0; i < 1000; ++i) {
    q[0] = 1e-3 * i + noise * (2 * random.Uniform(static_cast<std::uint64_t>(i), 0) - 1);
    resampler.Deposit(Time(std::chrono::milliseconds(1 + i)), q);
    resampler.Advance();
    const double third = resampler.Value(0)[0] - 3 * resampler.Value(1)[0] +
                         3 * resampler.Value(2)[0] - resampler.Value(3)[0];
    if (i > 500) heard.jerk = std::max(heard.jerk, std::abs(third) / (kT * kT * kT));
  }
  heard.behind = 0.999 - resampler.Value()[0];
  return heard;
}

TEST(ResamplerTest, AveragesTheNoiseThatNoRobotCanFollow) {
  constexpr double kJerk = 7500;
  Resampler bare(1000);
  EXPECT_GT(PlayWithNoise(bare, 1e-5).jerk, kJerk);
  Resampler resampler(1000, {.limit = {kJerk, kJerk, kJerk, kJerk, kJerk, kJerk, kJerk}});
  const Heard heard = PlayWithNoise(resampler, 1e-5);
  EXPECT_TRUE(resampler.is_rough());
  EXPECT_LT(heard.jerk, 1) << "a line";
  EXPECT_NEAR(heard.behind, PlayWithNoise(bare, 0).behind, 2e-5) << "without a lag of its own";
  EXPECT_LT(PlayWithNoise(resampler, 0).jerk, 1e-3);
  EXPECT_FALSE(resampler.is_rough()) << "a source that is smooth again is played as it is";
}

TEST(PoseResamplerTest, TurnsEvenlyBetweenItsDeposits) {
  PoseResampler resampler(100, test::PandaCartesianLimits());
  const auto pose = [](double t) { return model::Pose(model::Exp({0, 0, 3 * t}), {t, 0, 0}); };
  resampler.Reset(pose(0));
  for (int i = 0; i < 200; ++i) {  // two and a half turns: the quaternion's sign changes on the way
    resampler.Deposit(Time(std::chrono::milliseconds(1 + 10 * i)), pose(0.01 * i));
    for (int k = 0; k < 10; ++k) {
      resampler.Advance();
      if (i < 4) continue;
      EXPECT_NEAR(model::TurnBetween(resampler.Value(1), resampler.Value(0))[2], 3 * kT, 3e-5);
      EXPECT_NEAR(resampler.Value(0)[12] - resampler.Value(1)[12], kT, 1e-5);
    }
  }
}

TEST(ResamplerTest, RefusesARateOutOfRange) {
  EXPECT_THROW(Resampler(0.5), InputError);
  EXPECT_THROW(Resampler(1001), InputError);
}

TEST(ResamplerTest, AllocatesNothing) {
  Resampler resampler(1000);
  const test::RealtimeGuard guard;
  resampler.Reset({});
  for (int i = 0; i < 1000; ++i) {
    resampler.Deposit(Time(std::chrono::milliseconds(i + 1)), {});
    resampler.Advance();
    static_cast<void>(resampler.Value(3));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::reference::reference_resampler_test
