#include "twin/reference/viable_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "reference/all_words.h"
#include "reference/border_states.h"
#include "reference/hostile_world.h"
#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viability_filter.h"

namespace twin::reference::reference_viable_axis_test {
namespace {

constexpr double kT = kCycleSeconds;

/// Joints of the Panda, and of the FR3, whose velocity limit shrinks towards the ends of the range.
class ViableAxisOfTest : public ::testing::TestWithParam<JointLimits> {
 protected:
  [[nodiscard]] static AxisBounds Bounds(std::size_t joint) { return BoundsOf(GetParam(), joint); }
  [[nodiscard]] static ViableAxis Axis(std::size_t joint, int lost) {
    return AxisOf(GetParam(), joint, lost);
  }
};

std::string RobotOf(const ::testing::TestParamInfo<JointLimits>& tested) {
  return tested.index == 0 ? "Panda" : "Fr3";
}

INSTANTIATE_TEST_SUITE_P(Robots, ViableAxisOfTest,
                         ::testing::Values(test::PandaLimits(), test::Fr3Limits()), RobotOf);

TEST_P(ViableAxisOfTest, TheClosedFormIsTheWorstWayCycleByCycle) {
  for (const int lost : {0, 3, 19, 20}) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      const ViableAxis axis = Axis(joint, lost);
      States states(axis, 1);
      int viable = 0;
      for (int i = 0; i < 400; ++i) {
        const AxisState x = states.Next();
        const bool walks =
            WalksBelowUpper(x, axis) && WalksBelowUpper(Mirrored(x, axis.kept()), axis);
        if (std::abs(axis.Margin(x)) > 1e-12) {  // beyond rounding
          EXPECT_EQ(axis.Contains(x), walks) << "joint " << joint + 1 << ", n = " << lost << ": "
                                             << x.q << " " << x.dq << " " << x.ddq;
        }
        viable += walks ? 1 : 0;
      }
      EXPECT_GT(viable, 40);
      EXPECT_LT(viable, 360);
    }
  }
}

TEST_P(ViableAxisOfTest, FromAViableStateAJerkLeadsToAnother) {
  for (const int lost : {0, 3, 19}) {
    for (const std::size_t joint : {1U, 3U, 4U}) {
      const ViableAxis axis = Axis(joint, lost);
      States states(axis, 2);
      int seen = 0;
      for (int i = 0; i < 600; ++i) {
        AxisState x = states.Next();
        if (axis.Margin(x) < 1e-10) continue;
        ++seen;
        for (int k = 0; k <= lost; ++k) {
          const JerkRange range = axis.Admissible(x);
          ASSERT_FALSE(range.empty()) << "after " << k << " losses";
          EXPECT_GE(axis.Margin(ViableAxis::Step(x, range.lowest)), -1e-12);
          EXPECT_GE(axis.Margin(ViableAxis::Step(x, range.highest)), -1e-12);
          x = ViableAxis::Step(x, 0);
        }
      }
      EXPECT_GT(seen, 100);
    }
  }
}

TEST(ViableAxisTest, TheNearestJerkIsTheWishOrTheBorder) {
  const ViableAxis axis = PandaAxis(0, 19);
  States states(axis, 3);
  const Random random(3, RandomStream::kTest);
  int passed = 0;
  int changed = 0;
  for (int i = 0; i < 3000; ++i) {
    const AxisState x = states.Next();
    if (axis.Margin(x) < 1e-9) continue;
    const double wish = 15000 * (random.Uniform(static_cast<std::uint64_t>(i), 7) - 0.5);
    const double jerk = axis.Nearest(x, wish);
    if (jerk == wish) {
      ++passed;
      EXPECT_TRUE(axis.Contains(ViableAxis::Step(x, wish)));
      continue;
    }
    ++changed;
    const double towards = jerk + std::copysign(1e-3, wish - jerk);  // rad/s^3
    EXPECT_FALSE(axis.Contains(ViableAxis::Step(x, towards))) << wish << " -> " << jerk;
  }
  EXPECT_GT(passed, 200);
  EXPECT_GT(changed, 200);
}

/// At the border of the upper bounds, going up.
AxisState BeforeTheEnd(const ViableAxis& axis) {
  double inside = axis.kept().q_min;
  double outside = axis.kept().q_max;
  for (int i = 0; i < 60; ++i) {
    const double q = (inside + outside) / 2;
    (axis.Contains({q, 1, 0}) ? inside : outside) = q;
  }
  return {inside, 1, 0};
}

TEST(ViableAxisTest, ACommandForSeveralStatesIsTheNearestThatDoesInEach) {
  const ViableAxis axis = PandaAxis(0, 19);
  const AxisState end = BeforeTheEnd(axis);
  const double alone = axis.Nearest(end, 1000);
  ASSERT_LT(alone, -100);
  const std::array<PossibleState, 2> states{PossibleState{.x = {}}, PossibleState{end, 500}};
  EXPECT_NEAR(axis.NearestOfAll(states, 1000).value_or(NAN), alone - 500, 1e-3);
  const std::array<PossibleState, 2> jerky{PossibleState{.x = {}},
                                           PossibleState{.x = {}, .extra = 7000}};
  EXPECT_NEAR(axis.NearestOfAll(jerky, 1000).value_or(NAN), axis.kept().dddq_max - 7000, 1e-9);
}

TEST(ViableAxisTest, NoCommandDoesInStatesThatMustBrakeOppositeWays) {
  const ViableAxis axis = PandaAxis(0, 19);
  const AxisState end = BeforeTheEnd(axis);
  const std::array<PossibleState, 2> states{PossibleState{end, 0},
                                            PossibleState{Mirrored(end, axis.kept()), 0}};
  for (const double wish : {-1e9, 0.0, 1e9}) {
    EXPECT_FALSE(axis.NearestOfAll(states, wish).has_value());
  }
}

TEST_P(ViableAxisOfTest, KeepsItsBoundsWhateverIsWishedAndLost) {
  for (const int lost : {0, 1, 3, 19, 20}) {
    for (std::size_t joint = 0; joint < kJoints; ++joint) {
      const AxisBounds bounds = Bounds(joint);
      const ViableAxis axis = Axis(joint, lost);
      HostileWorld world(lost, 100 * static_cast<std::uint64_t>(lost) + joint);
      AxisState x{(bounds.q_min + bounds.q_max) / 2, 0, 0};
      double nearest = 1;
      for (int k = 0; k < 20000; ++k) {
        const double jerk = world.Loses() ? 0 : axis.Nearest(x, world.Wish(x, bounds));
        x = ViableAxis::Step(x, jerk);
        ASSERT_TRUE(KeepsGiven(x, jerk, bounds))
            << "joint " << joint + 1 << ", n = " << lost << ", cycle " << k << ": " << x.q << " "
            << x.dq << " " << x.ddq << " " << jerk;
        nearest = std::min(nearest, axis.Margin(x));
      }
      EXPECT_LT(nearest, 1e-6) << "the world was not hostile";
    }
  }
}

TEST(ViableAxisTest, EveryWordOfLossesKeepsTheBoundsFromItsBorder) {
  constexpr int kLength = 10;
  const AxisBounds bounds = BoundsOf(test::PandaLimits(), 0);
  for (const int lost : {1, 2, 3}) {
    const ViableAxis axis = PandaAxis(0, lost);
    States states(axis, 4);
    for (int i = 0; i < 20; ++i) {
      const AxisState x = states.NextAtBorder();
      for (const Wishes wishes : {Wishes::kUp, Wishes::kDown, Wishes::kSwitching}) {
        AllWords words(wishes, kLength);
        ASSERT_TRUE(words.Walk(axis, bounds, x)) << x.q << " " << x.dq << " " << x.ddq;
        EXPECT_GT(words.walked(), 100U);
      }
    }
  }
}

TEST(ViableAxisTest, StandsStillAnywhereInsideTheRange) {
  const ViableAxis axis = PandaAxis(1, 19);
  for (const double q : {axis.kept().q_min, 0.0, axis.kept().q_max}) {
    EXPECT_TRUE(axis.Contains({q, 0, 0}));
    EXPECT_EQ(axis.Nearest({q, 0, 0}, 0), 0);
  }
}

TEST(ViableAxisTest, BrakesWhereItIsLeftOutside) {
  const ViableAxis axis = PandaAxis(0, 19);
  const AxisState x{axis.kept().q_max - 0.01, 2.0, 0};
  ASSERT_FALSE(axis.Contains(x));
  EXPECT_EQ(axis.Nearest(x, 0), -axis.kept().dddq_max);
  EXPECT_TRUE(axis.Admissible(x).empty());
  EXPECT_LT(axis.Margin(x), 0);
}

TEST(ViableAxisTest, AWishThatIsNoNumberBrakes) {
  const ViableAxis axis = PandaAxis(0, 19);
  EXPECT_EQ(axis.Nearest({0, 1, 0}, NAN), -axis.kept().dddq_max);
  EXPECT_EQ(axis.Nearest({0, -1, 0}, NAN), axis.kept().dddq_max);
}

std::string RefusalOf(const AxisBounds& bounds, int lost) {
  try {
    const ViableAxis axis(bounds, lost, "joint 5");
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(ViableAxisTest, RefusesARangeTooSmallAndSaysWhatIsEnough) {
  AxisBounds bounds{-0.01, 0.01, 2.175, 15, 7500};
  const std::string refusal = RefusalOf(bounds, 19);
  EXPECT_NE(refusal.find("joint 5"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("0.02 rad"), std::string::npos) << refusal;
  const std::size_t at = refusal.find("at least ");
  ASSERT_NE(at, std::string::npos) << refusal;
  const double enough = std::stod(refusal.substr(at + 9));
  bounds.q_max = bounds.q_min + enough * 1.001;
  EXPECT_EQ(RefusalOf(bounds, 19), "");
}

TEST(ViableAxisTest, BoundsOfAnyKindAreRefusedOrKept) {
  const Random random(13, RandomStream::kTest);
  int kept = 0;
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 120; ++trial) {
    const auto between = [&](double low, double high, std::uint32_t draw) {
      return low * std::pow(high / low, random.Uniform(trial, draw));
    };
    const int lost = static_cast<int>(20 * random.Uniform(trial, 1));
    AxisBounds bounds{-50, 50, between(0.05, 5, 2), between(1, 50, 3), between(100, 50000, 4)};
    if (trial % 2 == 1) {
      bounds.deceleration = between(0.5, 50, 6);
      bounds.velocity_offset = between(0.01, 1, 7);
    }
    if (!RefusalOf(bounds, lost).empty()) {  // its speed
      ++refused;
      continue;
    }
    const double least = ViableAxis(bounds, lost, "joint").least_range() + 2e-6;
    bounds.q_max = bounds.q_min + least * between(0.5, 4, 5);
    if (!RefusalOf(bounds, lost).empty()) {
      ++refused;
      EXPECT_LT(bounds.q_max - bounds.q_min, least);
      continue;
    }
    ++kept;
    const ViableAxis axis(bounds, lost, "joint");
    HostileWorld world(lost, trial);
    AxisState x{(bounds.q_min + bounds.q_max) / 2, 0, 0};
    for (int k = 0; k < 3000; ++k) {
      const double jerk = world.Loses() ? 0 : axis.Nearest(x, world.Wish(x, bounds));
      x = ViableAxis::Step(x, jerk);
      ASSERT_TRUE(KeepsGiven(x, jerk, bounds)) << "trial " << trial << ", cycle " << k;
    }
  }
  EXPECT_GT(kept, 30);
  EXPECT_GT(refused, 10);
}

TEST(ViableAxisTest, RefusesASpeedThatLossesGather) {
  EXPECT_NE(RefusalOf({-10, 10, 0.1, 15, 7500}, 19).find("at least "), std::string::npos);
}

TEST(ViableAxisTest, RefusesWhatIsNoBound) {
  const AxisBounds good{-3, 3, 2, 15, 7500};
  EXPECT_EQ(RefusalOf(good, 19), "");
  AxisBounds bad = good;
  bad.ddq_max = NAN;
  EXPECT_NE(RefusalOf(bad, 19).find("ddq_max"), std::string::npos);
  bad = good;
  bad.q_min = 3;
  EXPECT_NE(RefusalOf(bad, 19).find("range"), std::string::npos);
  EXPECT_NE(RefusalOf(good, -1).find("[0, 100]"), std::string::npos);
  bad = good;
  bad.dddq_max = 1e-9;
  EXPECT_NE(RefusalOf(bad, 19), "");
  bad = good;
  bad.deceleration = -1;
  EXPECT_NE(RefusalOf(bad, 19).find("deceleration"), std::string::npos);
}

TEST(ViabilityFilterTest, WhatIsAdmissiblePassesBitByBit) {
  const ViabilityFilter filter(test::PandaLimits());
  const JointVector q{0.1, -0.7, 0.3, -2.1, 0.2, 1.5, 0.7};
  const JointVector dq{0.3, -0.2, 0.1, 0.4, -0.5, 0.6, 1};
  const JointVector ddq{1, -1, 2, 0.5, -3, 4, 1};
  JointVector wish{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    wish[i] = ViableAxis::Step({q[i], dq[i], ddq[i]}, 333.3).q;
  }
  const ViabilityFilter::Outcome outcome = filter.Next(q, dq, ddq, wish);
  EXPECT_EQ(outcome.q_c, wish);
  EXPECT_FALSE(outcome.any());
  EXPECT_GT(filter.Margin(q, dq, ddq), 0);
}

TEST(ViabilityFilterTest, OnlyTheJointThatWishesTooMuchIsChanged) {
  const ViabilityFilter filter(test::PandaLimits());
  const JointVector q{0.1, -0.7, 0.3, -2.1, 0.2, 1.5, 0.7};
  JointVector wish = q;
  wish[4] += 0.1;
  const ViabilityFilter::Outcome outcome = filter.Next(q, {}, {}, wish);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_EQ(outcome.active[i], i == 4);
    if (i != 4) {
      EXPECT_EQ(outcome.q_c[i], wish[i]);
    }
  }
  const double jerk = filter.axis(4).kept().dddq_max;
  EXPECT_NEAR(outcome.q_c[4], q[4] + kT * kT * kT * jerk, 1e-15);
}

TEST(ViabilityFilterTest, NextAllocatesNothing) {
  const ViabilityFilter filter(test::PandaLimits());
  const JointVector q{0.1, -0.7, 0.3, -2.1, 0.2, 1.5, 0.7};
  JointVector wish = q;
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    wish[static_cast<std::size_t>(i) % kJoints] += 0.01;
    static_cast<void>(filter.Next(q, {}, {}, wish));
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

TEST(ViabilityFilterTest, TheRefusalNamesTheJoint) {
  JointLimits limits = test::PandaLimits();
  limits.q_max[5] = limits.q_min[5] + 0.01;
  try {
    const ViabilityFilter filter(limits);
    FAIL() << "it was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("joint 6"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace twin::reference::reference_viable_axis_test
