#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <span>
#include <vector>

#include "reference/hostile_world.h"
#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/core/time.h"
#include "twin/reference/viability_in_flight.h"

namespace twin::reference {

/// A robot, and a client that answers a state d cycles late. To be copied: every copy is a future.
class LateWorld {
 public:
  using Joints = std::array<AxisState, kJoints>;

  /// @param velocities  commands are velocities, not positions.
  LateWorld(const ViabilityInFlight& filter, const Joints& start, bool velocities)
      : filter_(&filter), velocities_(velocities) {
    states_[0] = start;
  }

  /// What the filter makes of wished jerks, rad/s^3, from where the robot really is.
  [[nodiscard]] ViabilityInFlight::Outcome Decide(const JointVector& jerks) const {
    JointVector q{};
    JointVector dq{};
    JointVector ddq{};
    JointVector wish{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      q[i] = states_[0][i].q;
      dq[i] = states_[0][i].dq;
      ddq[i] = states_[0][i].ddq;
      const AxisState wished = ViableAxis::Step(now()[i], jerks[i]);
      wish[i] = velocities_ ? wished.dq : wished.q;
    }
    const auto since = std::span(since_).first(late_);
    return velocities_ ? filter_->NextVelocity(q, dq, ddq, since, wish)
                       : filter_->Next(q, dq, ddq, since, wish);
  }

  /// A cycle passes. @returns whether the robot's limits were kept.
  bool Advance(const ViabilityInFlight::Outcome& command, bool arrives) {
    constexpr double kT = kCycleSeconds;
    const JointLimits limits = test::PandaLimits();
    Joints next = now();
    bool kept = true;
    for (std::size_t i = 0; i < kJoints; ++i) {
      AxisState& x = next[i];
      double jerk = 0;
      if (command.send && arrives) {
        const double rate = velocities_ ? command.c[i] : (command.c[i] - x.q) / kT;
        jerk = ((rate - x.dq) / kT - x.ddq) / kT;
      }
      x = ViableAxis::Step(x, jerk);
      kept = kept && KeepsGiven(x, jerk, BoundsOf(limits, i));
    }
    Note(next, {.sent = command.send, .c = command.c});
    held_ = command.send && arrives ? 0 : held_ + 1;
    silent_ = command.send ? 0 : silent_ + 1;
    return kept;
  }

  [[nodiscard]] const Joints& now() const { return states_[late_]; }
  /// Cycles in a row without a command that arrived, and without one that was sent.
  [[nodiscard]] int held() const { return held_; }
  [[nodiscard]] int silent() const { return silent_; }

 private:
  void Note(const Joints& next, const InFlight& cycle) {
    if (late_ < static_cast<std::size_t>(filter_->in_flight())) {
      since_[late_] = cycle;
      states_[++late_] = next;
      return;
    }
    for (std::size_t i = 0; i < late_; ++i) {
      states_[i] = states_[i + 1];
      if (i + 1 < late_) since_[i] = since_[i + 1];
    }
    if (late_ > 0) since_[late_ - 1] = cycle;
    states_[late_] = next;
  }

  const ViabilityInFlight* filter_;
  bool velocities_;
  std::array<Joints, ViabilityInFlight::kMostInFlight + 1> states_{};  ///< oldest, seen, to now
  std::array<InFlight, ViabilityInFlight::kMostInFlight> since_{};
  std::size_t late_ = 0;
  int held_ = 0;
  int silent_ = 0;
};

/// At rest in the middle of the ranges.
[[nodiscard]] inline LateWorld::Joints AtRest() {
  const JointLimits limits = test::PandaLimits();
  LateWorld::Joints joints{};
  for (std::size_t i = 0; i < kJoints; ++i) joints[i].q = (limits.q_min[i] + limits.q_max[i]) / 2;
  return joints;
}

/// What is tried on a late client.
struct LateWorldOptions {
  bool velocities = false;  ///< its commands are velocities, not positions
  /// The wire is dead for up to n - 2 d cycles, then lets a command pass. Otherwise it loses up to
  /// most_lost() of the commands sent in a row.
  bool bursts = false;
  double most_jerk = 1e9;  ///< wished, as a share of the joint's limit

  friend std::ostream& operator<<(std::ostream& out, const LateWorldOptions& options) {
    return out << (options.velocities ? "velocities" : "positions")
               << (options.bursts ? ", bursts" : ", of those sent") << ", jerks up to "
               << options.most_jerk;
  }
};

/// Each with each: wild wishes, for which the client is often silent, and ones for which it is not.
[[nodiscard]] inline std::vector<LateWorldOptions> AllLateWorlds() {
  std::vector<LateWorldOptions> all;
  for (const bool velocities : {false, true}) {
    for (const bool bursts : {false, true}) {
      for (const double most_jerk : {1e9, 0.3, 0.08}) {
        all.push_back({.velocities = velocities, .bursts = bursts, .most_jerk = most_jerk});
      }
    }
  }
  return all;
}

/// Who wishes the worst of all joints of a late client, and a wire that loses as much as is
/// allowed.
class HostileLateWorld {
 public:
  HostileLateWorld(const ViabilityInFlight& filter, const LateWorldOptions& options,
                   std::uint64_t seed)
      : filter_(filter),
        world_(filter, AtRest(), options.velocities),
        options_(options),
        random_(seed, RandomStream::kTest) {
    for (std::size_t i = 0; i < kJoints; ++i) wishes_.emplace_back(0, seed + 1 + i);
  }

  /// A cycle passes. @returns whether the robot's limits were kept.
  bool Advance() {
    const JointLimits limits = test::PandaLimits();
    JointVector jerks{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double most = options_.most_jerk * limits.dddq_max[i];
      jerks[i] = std::clamp(wishes_[i].Wish(world_.now()[i], BoundsOf(limits, i)), -most, most);
    }
    const ViabilityInFlight::Outcome command = world_.Decide(jerks);
    sent_ += command.send ? 1 : 0;
    return world_.Advance(command, !Loses(command.send));
  }

  [[nodiscard]] const LateWorld& world() const { return world_; }
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

  /// Least margin of the joints, of where the robot is.
  [[nodiscard]] double Margin() const {
    double least = 1;
    for (std::size_t i = 0; i < kJoints; ++i) {
      least = std::min(least, filter_.axis(i).Margin(world_.now()[i]));
    }
    return least;
  }

 private:
  bool Loses(bool sent) {
    if (!sent && !options_.bursts) return false;
    if (run_ > 0) {
      --run_;
      return true;
    }
    const int most =
        options_.bursts ? filter_.axis(0).lost() - 2 * filter_.in_flight() : filter_.most_lost();
    // The command that passes, and after it the next run.
    if (sent && random_.Uniform(++draws_) < 0.5) {
      run_ = random_.Uniform(++draws_) < 0.7 ? most
                                             : static_cast<int>(most * random_.Uniform(++draws_));
    }
    return false;
  }

  const ViabilityInFlight& filter_;
  LateWorld world_;
  LateWorldOptions options_;
  Random random_;
  std::uint64_t draws_ = 0;
  int run_ = 0;
  std::uint64_t sent_ = 0;
  std::vector<HostileWorld> wishes_;
};

}  // namespace twin::reference
