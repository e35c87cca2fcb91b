// What the application `compliance` measures, on motions that are given by formulas.

#include <algorithm>
#include <cmath>
#include <string_view>

#include <gtest/gtest.h>

#include "application/compliance.h"

namespace twin::application::compliance::application_compliance_measures_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Gains kGains{.K_P = {500, 1000, 250, 10, 10, 10}, .K_D = {}};

plant::Push Push() {
  return {.body = "panda_hand",
          .begin = seconds(3),
          .duration = seconds(6),
          .rise = milliseconds(500),
          .force = {0, 6, -8}};
}

/// `off` and `force` as functions of the time, s, for so many seconds.
template <typename Off, typename Force>
Trace TraceOf(double length, Off off, Force force) {
  Trace trace;
  for (std::uint64_t cycle = 0; 1e-3 * static_cast<double>(cycle) < length; ++cycle) {
    const double t = 1e-3 * static_cast<double>(cycle);
    trace.push_back({.cycle = cycle, .p = off(t), .off = off(t), .force = force(t)});
  }
  return trace;
}

/// 1 from 3 s to 9 s, then falling by e every second.
double Pulse(double t) {
  if (t < 3) return 0;
  return t < 9 ? 1 : std::exp(9 - t);
}

/// `share` times Pulse of 10 mm along the push and 1 mm across it, off a place of its own.
Trace Pushed(double share) {
  return TraceOf(
      14,
      [share](double t) {
        const double s = share * Pulse(t);
        return Vector3{0.03 + s * 1e-3, 0.01 + s * 6e-3, -0.02 - s * 8e-3};
      },
      [share](double t) {
        return Vector3{2, 1 + share * 6 * Pulse(t), 3 - share * 8 * Pulse(t)};
      });
}

TEST(ComplianceMeasuresTest, DeflectionIsAlongThePushFromWhereTheArmWasBeforeIt) {
  const Response r = ResponseOf(Pushed(1), nullptr, Push(), kGains).value();
  EXPECT_NEAR(r.peak, 0.01, 1e-9);
  EXPECT_NEAR(r.steady, 0.01, 1e-9);
  EXPECT_NEAR(*std::ranges::max_element(r.across), 1e-3, 1e-9);
  EXPECT_NEAR(r.force, 10, 1e-9);
  EXPECT_NEAR(r.estimated_steady, 10, 1e-9);
  // Each axis gives way by its own spring: 0.6 6/1000 + 0.8 8/250.
  EXPECT_NEAR(r.expected, 0.6 * 6e-3 + 0.8 * 32e-3, 1e-9);
}

TEST(ComplianceMeasuresTest, SettledIsWhenATenthIsLeftForGood) {
  const Response r = ResponseOf(Pushed(1), nullptr, Push(), kGains).value();
  ASSERT_TRUE(r.settling);
  EXPECT_NEAR(*r.settling, std::log(10), 2e-3);
  Trace never = Pushed(1);
  never.back().off[1] += 0.01;
  EXPECT_FALSE(ResponseOf(never, nullptr, Push(), kGains).value().settling);
}

TEST(ComplianceMeasuresTest, OnATrajectoryWhatAlsoMovesTheUntouchedArmIsNoDeflection) {
  const auto swaying = [](Trace trace) {
    for (Sample& sample : trace) sample.off[1] += 0.05 * std::sin(sample.t());
    return trace;
  };
  Trace untouched = swaying(Pushed(0));
  const Response r = ResponseOf(swaying(Pushed(1)), &untouched, Push(), kGains).value();
  EXPECT_NEAR(r.peak, 0.01, 1e-9);
  EXPECT_NEAR(r.steady, 0.01, 1e-9);
  // A lost state of the one is bridged by the one before it.
  untouched.erase(untouched.begin() + 5000, untouched.begin() + 5010);
  EXPECT_NEAR(ResponseOf(swaying(Pushed(1)), &untouched, Push(), kGains).value().peak, 0.01, 1e-3);
}

TEST(ComplianceMeasuresTest, AMotionThatEndedUnderThePushHasNoResponse) {
  Trace cut = Pushed(1);
  cut.resize(8000);
  EXPECT_FALSE(ResponseOf(cut, nullptr, Push(), kGains));
  EXPECT_FALSE(ResponseOf(Pushed(1), &cut, Push(), kGains));
}

TEST(ComplianceMeasuresTest, TheNullSpaceCountsOnceTheSoftStartIsOver) {
  const Config config;
  Trace trace = TraceOf(
      8,
      [](double t) {
        return Vector3{t < 2 ? 0.0 : 5e-3, 1e-3 * std::max(t - 2, 0.0), 0};
      },
      [](double) { return Vector3{}; });
  for (Sample& sample : trace) sample.q[4] = 0.05 * sample.t();
  const Wandering w = WanderingOf(trace, config).value();
  EXPECT_NEAR(w.end_effector, 6e-3, 1e-5);
  EXPECT_NEAR(w.joints, 0.3, 1e-3);
  trace.resize(1999);
  EXPECT_FALSE(WanderingOf(trace, config));
}

TEST(ComplianceMeasuresTest, TrackingIsTheDistanceFromTheReference) {
  const Tracking t = TrackingOf({{.off = {3e-3, 0, 4e-3}, .turned = 0.1}, {.turned = 0.2}});
  EXPECT_NEAR(t.largest, 5e-3, 1e-12);
  EXPECT_NEAR(t.rms, 5e-3 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(t.largest_turned, 0.2, 1e-12);
}

/// Measures that meet all that is demanded.
Measures Good() {
  Measures m;
  for (const CaseIndex index : {kA, kB, kC, kD}) {
    const double expected = kAllCases[index].is_stiff ? 0.01 : 0.1;
    m.responses[index] = Response{.t = {0, 1},
                                  .peak = 1.1 * expected,
                                  .steady = 1.05 * expected,
                                  .expected = expected,
                                  .force = 10};
  }
  m.trackings[kC0] = Tracking{.largest = 4e-3};
  m.wandering = Wandering{.joints = 0.3, .end_effector = 1e-3};
  m.torque = 0.5;
  m.rate = 0.1;
  return m;
}

/// The demands that are missed, by the beginning of what they are about.
std::vector<std::string> MissedOf(const Measures& m) {
  std::vector<std::string> missed;
  const Evaluation evaluation = EvaluateCases(m);
  for (const Finding& finding : evaluation.findings) {
    if (finding.met == false) missed.push_back(finding.quantity);
  }
  return missed;
}

TEST(ComplianceMeasuresTest, EveryDemandCanBeMissed) {
  EXPECT_EQ(MissedOf(Good()), std::vector<std::string>{});
  const auto missed = [](const auto& change) {
    Measures m = Good();
    change(m);
    const std::vector<std::string> all = MissedOf(m);
    return all.size() == 1 ? all.front() : std::to_string(all.size()) + " missed";
  };
  using M = Measures;
  EXPECT_EQ(missed([](M& m) { m.responses[kA]->peak = 0.0221; }),
            "A: largest deflection / that of B");
  EXPECT_EQ(missed([](M& m) { m.responses[kD]->peak = 0.0549; }),
            "C: largest deflection / that of D");
  EXPECT_EQ(missed([](M& m) { m.responses[kB]->steady = 0.1101; }),
            "B: deflection under the constant force");
  EXPECT_EQ(missed([](M& m) { m.responses[kC]->steady = 0.0089; }),
            "C: deflection under the constant force");
  EXPECT_EQ(missed([](M& m) { m.trackings[kC0]->largest = 5.1e-3; }),
            "C0: tracking error, largest");
  EXPECT_EQ(missed([](M& m) { m.wandering->end_effector = 2.1e-3; }),
            "N: end effector motion meanwhile, largest");
  EXPECT_EQ(missed([](M& m) { m.wandering->joints = 0.09; }),
            "N: joint motion in the null space, largest");
  EXPECT_EQ(missed([](M& m) { m.torque = 1.01; }), "peak torque / limit, measured or commanded");
  EXPECT_EQ(missed([](M& m) { m.rate = 1.01; }), "peak rate of the commanded torque / limit");
  EXPECT_EQ(missed([](M& m) { m.reflexes = 1; }), "reflexes");
}

}  // namespace
}  // namespace twin::application::compliance::application_compliance_measures_test
