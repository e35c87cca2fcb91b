#pragma once

#include <cstdint>

#include "reference/border_states.h"
#include "reference/hostile_world.h"
#include "reference/late_world.h"
#include "twin/reference/viability_in_flight.h"

namespace twin::reference {

/// Jerks that are wished of a joint along a word of losses.
enum class Wishes { kUp, kDown, kSwitching, kGentleUp, kGentleDown };

/// rad/s^3. The gentle ones are such that a client with commands in flight is not silent for them.
[[nodiscard]] inline double WishOf(Wishes wishes, const AxisBounds& bounds, int cycle) {
  constexpr double kTooMuch = 1e9;
  switch (wishes) {
    case Wishes::kUp: return kTooMuch;
    case Wishes::kDown: return -kTooMuch;
    case Wishes::kSwitching: return cycle / 2 % 2 == 0 ? kTooMuch : -kTooMuch;
    case Wishes::kGentleUp: return bounds.dddq_max / 12;
    default: return -bounds.dddq_max / 12;
  }
}

/// Every word of losses of a length, but those in which more are lost in a row than may be: a tree
/// whose branches share what they have in common.
class AllWords {
 public:
  AllWords(Wishes wishes, int length) : wishes_(wishes), length_(length) {}

  /// Of a joint whose client has nothing in flight. @returns whether the given bounds were kept.
  bool Walk(const ViableAxis& axis, const AxisBounds& bounds, const AxisState& x, int cycle = 0,
            int run = 0) {
    if (cycle == length_) return Count();
    const double jerk = axis.Nearest(x, WishOf(wishes_, bounds, cycle));
    const AxisState taken = ViableAxis::Step(x, jerk);
    if (!KeepsGiven(taken, jerk, bounds)) return false;
    if (!Walk(axis, bounds, taken, cycle + 1, 0)) return false;
    if (run == axis.lost()) return true;
    const AxisState held = ViableAxis::Step(x, 0);
    return KeepsGiven(held, 0, bounds) && Walk(axis, bounds, held, cycle + 1, run + 1);
  }

  /// Of a robot whose client is late; the words are of the commands that are sent. @param joint
  /// wishes as told, the others nothing. @returns whether the limits were kept, and no more cycles
  /// were held in a row than the robot bridges.
  bool Walk(const ViabilityInFlight& filter, const LateWorld& world, std::size_t joint,
            int cycle = 0, int run = 0) {
    if (world.held() > filter.axis(joint).lost()) return false;
    if (cycle == length_) return Count();
    JointVector jerks{};
    jerks[joint] = WishOf(wishes_, BoundsOf(test::PandaLimits(), joint), cycle);
    const ViabilityInFlight::Outcome command = world.Decide(jerks);
    if (command.send) {
      LateWorld taken = world;
      if (!taken.Advance(command, true) || !Walk(filter, taken, joint, cycle + 1, 0)) return false;
      if (run == filter.most_lost()) return true;
    }
    LateWorld held = world;
    return held.Advance(command, false) &&
           Walk(filter, held, joint, cycle + 1, run + (command.send ? 1 : 0));
  }

  [[nodiscard]] std::uint64_t walked() const { return walked_; }

 private:
  bool Count() {
    ++walked_;
    return true;
  }

  Wishes wishes_;
  int length_;
  std::uint64_t walked_ = 0;
};

/// At rest, but for a joint at the border of its viable set.
[[nodiscard]] inline LateWorld::Joints AtBorder(std::size_t joint, const AxisState& x) {
  LateWorld::Joints joints = AtRest();
  joints[joint] = x;
  return joints;
}

}  // namespace twin::reference
