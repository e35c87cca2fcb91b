#include "twin/reference/resampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::reference {
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
      played.push_back(resampler_.Next()[0]);
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

TEST(ResamplerTest, StandsAtTheLastDepositOfASourceThatStops) {
  Resampler resampler(100);
  JointVector q{};
  resampler.Reset(q);
  for (int i = 0; i < 30; ++i) {
    q[3] = 0.01 * i;
    resampler.Deposit(Time(std::chrono::milliseconds(1000 + 10 * i)), q);
    for (int k = 0; k < 10; ++k) static_cast<void>(resampler.Next());
  }
  EXPECT_FALSE(resampler.ended());
  for (int k = 0; k < 60; ++k) static_cast<void>(resampler.Next());
  EXPECT_TRUE(resampler.ended());
  EXPECT_EQ(resampler.Next(), q);
}

TEST(ResamplerTest, GoesOnWithASourceWhoseTimeJumped) {
  Resampler resampler(1000);
  JointVector q{};
  resampler.Reset(q);
  double played = 0;
  for (int i = 0; i < 400; ++i) {
    const int ms = i < 200 ? i : i + 5000;
    q[0] = 1e-3 * ms;
    resampler.Deposit(Time(std::chrono::milliseconds(1000 + ms)), q);
    played = resampler.Next()[0];
  }
  EXPECT_NEAR(played, q[0] - resampler.lag_s(), 2e-3);
}

TEST(ResamplerTest, PlaysWhereTheMotionBeginsUntilADepositComes) {
  Resampler resampler(1000);
  JointVector q{};
  q.fill(0.5);
  resampler.Reset(q);
  EXPECT_EQ(resampler.Next(), q);
  EXPECT_EQ(resampler.Next(), q);
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
    static_cast<void>(resampler.Next());
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::reference
