#include "twin/reference/viability_in_flight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "reference/all_words.h"
#include "reference/border_states.h"
#include "reference/late_world.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::reference::reference_viability_in_flight_test {
namespace {

constexpr double kT = kCycleSeconds;

const JointVector kAnywhere{0.1, -0.7, 0.3, -2.1, 0.2, 1.5, 0.7};

/// A command for all joints, positions, by the share of each joint's greatest jerk from kAnywhere.
InFlight SentWith(const ViabilityInFlight& filter, double share) {
  InFlight command{.sent = true};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double jerk = share * filter.axis(i).kept().dddq_max;
    command.c[i] = ViableAxis::Step({kAnywhere[i], 0, 0}, jerk).q;
  }
  return command;
}

TEST(ViabilityInFlightTest, WithNothingInFlightItIsTheFilter) {
  const ViabilityFilter filter(test::PandaLimits());
  const ViabilityInFlight late(test::PandaLimits(), 0);
  std::vector<States> states;
  for (std::size_t i = 0; i < kJoints; ++i) states.emplace_back(filter.axis(i), 11 + i);
  const Random random(11, RandomStream::kTest);
  for (std::uint64_t k = 0; k < 300; ++k) {
    std::array<JointVector, 4> x{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      const AxisState at = states[i].Next();
      const double jerk = 20000 * (random.Uniform(k, static_cast<std::uint32_t>(i)) - 0.5);
      x[0][i] = at.q;
      x[1][i] = at.dq;
      x[2][i] = at.ddq;
      x[3][i] = ViableAxis::Step(at, jerk).q;
    }
    const ViabilityInFlight::Outcome outcome = late.Next(x[0], x[1], x[2], {}, x[3]);
    ASSERT_TRUE(outcome.send);
    ASSERT_EQ(outcome.c, filter.Next(x[0], x[1], x[2], x[3]).q_c);
  }
}

TEST(ViabilityInFlightTest, KeepsItsBoundsWhateverIsWishedAndLost) {
  for (const int in_flight : {1, 2}) {
    const ViabilityInFlight filter(test::PandaLimits(), in_flight);
    for (const LateWorldOptions& options : AllLateWorlds()) {
      HostileLateWorld world(filter, options, 5);
      double nearest = 1;
      for (int k = 0; k < 3000; ++k) {
        ASSERT_TRUE(world.Advance()) << "d = " << in_flight << ", " << options << ", cycle " << k;
        nearest = std::min(nearest, world.Margin());
      }
      EXPECT_LT(nearest, 1e-3) << "the world was not hostile: " << options;
    }
  }
}

TEST(ViabilityInFlightTest, IsSilentNoLongerThanCommandsAreInFlight) {
  for (const int in_flight : {1, 2}) {
    for (const bool bursts : {false, true}) {
      const ViabilityInFlight filter(test::PandaLimits(), in_flight);
      HostileLateWorld world(filter, {.bursts = bursts}, 6);
      int silent = 0;
      int held = 0;
      for (int k = 0; k < 3000; ++k) {
        world.Advance();
        silent = std::max(silent, world.world().silent());
        held = std::max(held, world.world().held());
      }
      EXPECT_EQ(silent, in_flight);
      EXPECT_LE(held, 19);  // the robot aborts at 20
      EXPECT_GT(held, 15) << "the world was not hostile";
    }
  }
}

TEST(ViabilityInFlightTest, EveryWordOfLossesKeepsTheBoundsFromTheBorder) {
  constexpr int kLength = 10;
  for (const auto& [in_flight, held] : {std::pair{1, 3}, {1, 19}, {2, 5}, {2, 19}}) {
    const ViabilityInFlight filter(test::PandaLimits(), in_flight, held);
    for (const std::size_t joint : {std::size_t{1}, std::size_t{5}}) {
      States states(filter.axis(joint), 21 + joint);
      for (const Wishes wishes :
           {Wishes::kUp, Wishes::kSwitching, Wishes::kGentleUp, Wishes::kGentleDown}) {
        const LateWorld world(filter, AtBorder(joint, states.NextAtBorder()), false);
        AllWords words(wishes, kLength);
        ASSERT_TRUE(words.Walk(filter, world, joint)) << "d = " << in_flight << ", n = " << held;
        EXPECT_GT(words.walked(), 4U);
      }
    }
  }
}

TEST(ViabilityInFlightTest, ASmoothReferencePassesUnchangedWhileNothingIsLost) {
  for (const auto& [in_flight, share] : {std::pair{1, 0.249}, {2, 0.099}}) {
    const ViabilityInFlight filter(test::PandaLimits(), in_flight);
    LateWorld world(filter, AtRest(), false);
    for (int k = 0; k < 400; ++k) {
      JointVector jerks{};
      for (std::size_t i = 0; i < kJoints; ++i) {
        const double most = share * test::PandaLimits().dddq_max[i];
        jerks[i] = most * std::cos(6.283 * k / 30);
      }
      const ViabilityInFlight::Outcome command = world.Decide(jerks);
      ASSERT_TRUE(command.send) << "d = " << in_flight << ", cycle " << k;
      ASSERT_EQ(command.active, (std::array<bool, kJoints>{}));
      ASSERT_TRUE(world.Advance(command, true));
    }
  }
}

TEST(ViabilityInFlightTest, WhereNoCommandIsAdmissibleInBothStatesNothingIsSent) {
  // If the command with the greatest jerk is lost, a position is 3 times that jerk more: in
  // [-J, J] in both states none is.
  const ViabilityInFlight filter(test::PandaLimits(), 1);
  const InFlight full = SentWith(filter, 1);
  EXPECT_FALSE(filter.Next(kAnywhere, {}, {}, {&full, 1}, full.c).send);
  const InFlight two_thirds = SentWith(filter, 0.66);
  EXPECT_TRUE(filter.Next(kAnywhere, {}, {}, {&two_thirds, 1}, two_thirds.c).send);
  const InFlight silent{};
  EXPECT_TRUE(filter.Next(kAnywhere, {}, {}, {&silent, 1}, kAnywhere).send);
}

TEST(ViabilityInFlightTest, TheNearestCommandIsAtTheBorderInOneOfTheStates) {
  const ViabilityInFlight filter(test::PandaLimits(), 1);
  const InFlight before = SentWith(filter, 0.3);
  JointVector wish = before.c;
  for (double& q : wish) q += 1;
  const ViabilityInFlight::Outcome command = filter.Next(kAnywhere, {}, {}, {&before, 1}, wish);
  ASSERT_TRUE(command.send);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double J = filter.axis(i).kept().dddq_max;
    const AxisState taken = ViableAxis::Step({kAnywhere[i], 0, 0}, 0.3 * J);
    // In the state after a loss, at rest, the whole jerk.
    EXPECT_NEAR((command.c[i] - kAnywhere[i]) / (kT * kT * kT) / J, 1, 1e-9);
    EXPECT_NEAR((((command.c[i] - taken.q) / kT - taken.dq) / kT - taken.ddq) / kT / J, 0.1, 1e-9);
  }
}

TEST(ViabilityInFlightTest, SaysHowManyOfTheCommandsSentMayBeLost) {
  EXPECT_EQ(ViabilityInFlight(test::PandaLimits(), 0).most_lost(), 19);
  EXPECT_EQ(ViabilityInFlight(test::PandaLimits(), 1).most_lost(), 9);
  EXPECT_EQ(ViabilityInFlight(test::PandaLimits(), 2).most_lost(), 5);
}

TEST(ViabilityInFlightTest, MoreInFlightThanItWasToldOfIsAnsweredBySilence) {
  const ViabilityInFlight filter(test::PandaLimits(), 1);
  const std::array<InFlight, 2> since{};
  EXPECT_FALSE(filter.Next(kAnywhere, {}, {}, since, kAnywhere).send);
}

TEST(ViabilityInFlightTest, AWishThatIsNoNumberIsNotSentAsItIs) {
  const ViabilityInFlight filter(test::PandaLimits(), 2);
  const std::array<InFlight, 2> since{SentWith(filter, 0.1), InFlight{}};
  JointVector wish = kAnywhere;
  wish[3] = NAN;
  const ViabilityInFlight::Outcome command = filter.Next(kAnywhere, {}, {}, since, wish);
  EXPECT_TRUE(command.send);
  EXPECT_TRUE(command.active[3]);
  EXPECT_TRUE(std::isfinite(command.c[3]));
}

std::string RefusalOf(int in_flight, int held) {
  try {
    const ViabilityInFlight filter(test::PandaLimits(), in_flight, held);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(ViabilityInFlightTest, RefusesNumbersOutOfRange) {
  EXPECT_NE(RefusalOf(3, 19).find("3 commands in flight; the number must be in [0, 2]"),
            std::string::npos);
  EXPECT_NE(RefusalOf(-1, 19), "");
  EXPECT_NE(RefusalOf(2, 1).find("1 cycles to bridge with 2 commands"), std::string::npos);
  EXPECT_EQ(RefusalOf(2, 2), "");
}

/// The greatest jerk, in steps of 1 / per_unit of the limit, of a command that follows one that
/// arrived, from which a client that is never silent can go on: d = 1, n losses in a row,
/// positions. By taking away, until nothing changes, every jerk after r losses in a row from which
/// no next command leads to one that is left, whether this one arrives or not.
int GreatestJerk(int lost, int per_unit) {
  // left[r]: those from -left[r] to left[r] are left. More than n are not lost in a row.
  std::vector<int> left(static_cast<std::size_t>(lost) + 1, per_unit);
  const auto leads_on = [&](std::size_t r, int jerk) {
    if (r + 1 == left.size()) return true;  // it arrives: the state is certain
    for (int next = -left[0]; next <= left[0]; ++next) {
      if (std::abs(next + 3 * jerk) <= left[r + 1]) return true;
    }
    return false;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t r = 0; r < left.size(); ++r) {
      while (left[r] > 0 && !leads_on(r, left[r])) {
        --left[r];
        changed = true;
      }
    }
  }
  return left[0];
}

TEST(ViabilityInFlightTest, WithoutSilenceTheJerksDieOut) {
  for (const int lost : {1, 2, 3}) {
    const double greatest = 2 / (std::pow(3, lost) + 1);
    EXPECT_NEAR(GreatestJerk(lost, 2800) / 2800.0, greatest, 2.0 / 2800) << "n = " << lost;
  }
}

TEST(ViabilityInFlightTest, NextAllocatesNothing) {
  const ViabilityInFlight filter(test::PandaLimits(), 2);
  LateWorld world(filter, AtRest(), false);
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    JointVector jerks;
    jerks.fill(k % 2 == 0 ? 1e9 : -700);
    world.Advance(world.Decide(jerks), k % 5 != 0);
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

}  // namespace
}  // namespace twin::reference::reference_viability_in_flight_test
