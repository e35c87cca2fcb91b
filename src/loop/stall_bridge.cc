#include "twin/loop/stall_bridge.h"

#include <algorithm>
#include <cmath>

#include "twin/model/rotation.h"

namespace twin::loop {
namespace {

using control::CommandInterface;

constexpr double kT = kCycleSeconds;

/// Of a motion, 1/s.
constexpr double kOmega = 6;

/// Of a torque on its way back to the demand, Nm/s; and behind a source that is stalled, 1/s.
constexpr double kTorqueRate = 500;
constexpr double kTorqueDecay = 10;

/// Unserved cycles in a row after which the demand is no longer what the robot does. After one the
/// generator's own way back costs three times the trajectory's jerk.
constexpr std::uint64_t kLapse = 2;

/// Cycles that one step takes a difference on by, at most: the tick is bounded.
constexpr std::uint64_t kLongestStep = 64;

/// The drawn motion: its fastest, 1/s, and what of a difference, as speed and w, keeps the
/// acceleration gentle, 1/s^2.
constexpr double kLargestOmega = 20;
constexpr double kGentle = 8;

/// Largest w with which a difference is taken away from a motion, 1/s.
constexpr double kLargestReturn = 30;

/// The demand's own acceleration is that over this time, s, and at most that, 1/s^2: a jump is no
/// acceleration. More, or faster, makes the drawn motion swing behind a source that lapses often.
constexpr double kSlow = 0.05;
constexpr double kLargestFeed = 1;

/// Commands it goes on for after a lapse, at most: half a second.
constexpr std::uint64_t kLongestGoingOn = 512;

/// Commands without a lapse, after those, that make the next one a new lapse.
constexpr std::uint64_t kRecovered = 48;

/// A difference this small is gone: as a velocity it makes a jerk of 1e-4 rad/s^3.
constexpr double kGone = 1e-10;

/// Twist that leads from one pose to the other in a cycle, base axes.
std::array<double, kJoints> TwistBetween(const Transform& from, const Transform& to) {
  const Eigen::Vector3d turn = model::TurnBetween(from, to);
  std::array<double, kJoints> twist{};
  for (std::size_t i = 0; i < 3; ++i) {
    twist[i] = (to[12 + i] - from[12 + i]) / kT;
    twist[3 + i] = turn[static_cast<Eigen::Index>(i)] / kT;
  }
  return twist;
}

/// `pose` after one cycle of `twist`.
Transform Moved(const Transform& pose, const std::array<double, kJoints>& twist) {
  const Eigen::Vector3d turn(twist[3], twist[4], twist[5]);
  const Eigen::Vector3d move(twist[0], twist[1], twist[2]);
  return model::Turned(pose, kT * turn, model::Position(pose) + kT * move);
}

std::array<double, kJoints> Widened(const Vector6& values) {
  std::array<double, kJoints> wide{};
  std::ranges::copy(values, wide.begin());
  return wide;
}

}  // namespace

void StallBridge::Difference::Step() noexcept {
  const double decay = std::exp(-omega * kT);
  const double drive = rate + omega * x;
  x = (x + drive * kT) * decay;
  rate = (rate - omega * drive * kT) * decay;
  if (std::abs(x) < kGone && std::abs(rate) < kGone) *this = Difference();
}

StallBridge::StallBridge(CommandInterface interface, std::uint64_t period_cycles) noexcept
    : interface_(interface), period_cycles_(period_cycles) {}

void StallBridge::Reset() noexcept {
  *this = StallBridge(interface_, period_cycles_);
}

bool StallBridge::settled() const noexcept {
  constexpr double kSettled = 1e-4;
  constexpr double kSettledRate = 0.1;
  return std::ranges::all_of(difference_, [](const Difference& e) {
    return std::abs(e.x) <= kSettled && std::abs(e.rate) <= kSettledRate;
  });
}

bool StallBridge::IsLate(std::uint64_t cycles, Time source_time) const noexcept {
  if (waited_ > period_cycles_) return true;
  if (!source_time_) return false;
  const auto robot = static_cast<std::int64_t>(waited_ + cycles);
  const auto period = static_cast<std::int64_t>(period_cycles_);
  return source_time - *source_time_ > kCycle * (robot + period) + kCycle / 2;
}

void StallBridge::Observe(bool fresh, std::uint64_t cycles, Time source_time,
                          std::uint64_t unserved) noexcept {
  const bool was_stalled = stalled();
  const bool late = fresh && IsLate(cycles, source_time);
  waited_ = fresh ? 0 : waited_ + cycles;
  if (fresh) source_time_ = source_time;
  cycles_ = std::min(cycles, kLongestStep);
  // A late deposit's velocity is the mean over its delay, the next one's is the present one; behind
  // a rate matcher both take a window to come through.
  const std::uint64_t since = since_lapse_ + cycles;
  since_lapse_ = std::min(since, kLongestGoingOn + kRecovered);
  if (late || unserved >= kLapse || stalled() != was_stalled) {
    const std::uint64_t once = 2 * period_cycles_ + 3;
    const bool recurs = active_ && since < going_for_ + kRecovered;
    going_for_ = recurs ? std::max(once, std::min(2 * going_for_, kLongestGoingOn)) : once;
    going_on_ = going_for_;
    active_ = true;
    since_lapse_ = 0;
  }
}

double StallBridge::Drawn(std::size_t i, double demand, double last, double rate) const noexcept {
  const double missing = demand - last;
  const double feed = std::clamp((demand - slow_[i]) / kSlow, -kLargestFeed, kLargestFeed);
  const double omega = OmegaOf(missing, kLargestOmega);
  return last + kT * (rate + kT * omega * (omega * missing + 2 * (feed - rate)));
}

double StallBridge::OmegaOf(double difference, double largest) noexcept {
  return std::clamp(kGentle / std::max(std::abs(difference), kGone), kOmega, largest);
}

void StallBridge::CarryValues(Values& demand, const Values& last, const Values& rate) noexcept {
  const bool goes_on = going_on_ > 0;
  // What the difference rises by is taken over the last N + 2 of these commands: the jitter of
  // single deposits evens out, and the late one's mean velocity is past.
  const bool is_first = going_on_ == period_cycles_ + 3;
  since_first_ = is_first ? 0 : since_first_ + cycles_;
  going_on_ -= goes_on ? 1 : 0;
  active_ = goes_on;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!carrying_) slow_[i] = demand[i] - kSlow * rate[i];
    slow_[i] += std::min(static_cast<double>(cycles_) * kT / kSlow, 1.0) * (demand[i] - slow_[i]);
    Difference& e = difference_[i];
    if (goes_on) {
      const double x = demand[i] - Drawn(i, demand[i], last[i], rate[i]);
      if (is_first) first_[i] = x;
      const bool has_rise = going_on_ + 1 < period_cycles_ + 3;
      e = {x, has_rise ? (x - first_[i]) / (kT * static_cast<double>(since_first_)) : -rate[i],
           OmegaOf(x, kLargestReturn)};
    } else {
      for (std::uint64_t k = 0; k < cycles_; ++k) e.Step();
    }
    demand[i] -= e.x;
    active_ = active_ || !e.gone();
  }
  carrying_ = active_;
}

void StallBridge::CarryTorques(const JointVector& last, JointVector& demand) noexcept {
  active_ = stalled();
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (stalled()) demand[i] = std::abs(last[i]) < kGone ? 0 : last[i] * (1 - kTorqueDecay * kT);
    const double missing = demand[i] - last[i];
    if (std::abs(missing) <= kTorqueRate * kT) continue;
    demand[i] = last[i] + std::copysign(kTorqueRate * kT, missing);
    active_ = true;
  }
}

void StallBridge::Carry(const RobotState& state, RobotCommand& command) noexcept {
  switch (interface_) {
    case CommandInterface::kJointPosition: {
      Values dq{};
      for (std::size_t i = 0; i < kJoints; ++i) dq[i] = (command.q_c[i] - state.q_d[i]) / kT;
      CarryValues(dq, state.dq_d, state.ddq_d);
      for (std::size_t i = 0; i < kJoints; ++i) command.q_c[i] = state.q_d[i] + kT * dq[i];
      break;
    }
    case CommandInterface::kJointVelocity:
      CarryValues(command.dq_c, state.dq_d, state.ddq_d);
      break;
    case CommandInterface::kTorque: CarryTorques(state.tau_J_d, command.tau_J_d); break;
    case CommandInterface::kCartesianPose: {
      Values twist = TwistBetween(state.O_T_EE_c, command.O_T_EE_c);
      CarryValues(twist, Widened(state.O_dP_EE_c), Widened(state.O_ddP_EE_c));
      command.O_T_EE_c = Moved(state.O_T_EE_c, twist);
      break;
    }
  }
}

}  // namespace twin::loop
