#include "twin/onboard/gripper.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "twin/core/time.h"

namespace twin::onboard {
namespace {

// Motion of a finger: critically damped at 100 rad/s for the drive's reflected mass of 1 kg.
constexpr double kStiffness = 1e4;   // N/m
constexpr double kDamping = 200;     // N s/m
constexpr double kMotionForce = 30;  // N, unless a grasp sets its own
constexpr double kMostSpeed = 0.1;   // of the opening, m/s

constexpr double kHomingSpeed = 0.05;
constexpr double kHomingForce = 10;
constexpr double kBeyondStop = 0.02;   // by which homing and grasps aim past the stop, m
constexpr double kClosedWidth = 1e-3;  // wider at the lower stop: an object is in between

constexpr double kContactForce = 5;        // N
constexpr double kSlowShare = 0.1;         // of the motion's speed: below, a finger hardly moves
constexpr double kLeastSlowSpeed = 1e-6;   // of the opening, m/s
constexpr double kStillSpeed = 2e-3;       // of the opening, m/s: below, it is at rest
constexpr double kArrivedWithin = 0.2e-3;  // m

constexpr double kRacingSpeed = 0.15;  // of a finger, m/s: a pressing drive gives no force
constexpr int kRiseCycles = 100;       // of a grasp's force
constexpr int kSettledCycles = 50;     // at rest, before an opening is checked
constexpr int kGraspedCycles = 20;     // at rest, before an object counts as held
constexpr int kGraspTimeout = 2000;    // to come to rest after contact
constexpr int kMoveTimeout = 500;      // blocked by an obstacle
constexpr int kReleaseCycles = 50;     // without force, so that a squeezed object is released
constexpr int kMostCounted = 1 << 20;  // more than any of these: a hand may be on for months

constexpr double kAmbient = 25;     // degrees Celsius
constexpr double kHeating = 25;     // the same, at the force below
constexpr double kRatedForce = 70;  // N
constexpr double kWarmUpSeconds = 300;

double Clamp(double value, double magnitude) noexcept {
  return std::clamp(value, -magnitude, magnitude);
}

}  // namespace

Gripper::Gripper(const HandSensors& sensors) noexcept
    : sensors_(sensors),
      width_d_(sensors.width),
      target_(sensors.width),
      force_limit_(kMotionForce),
      phase_cycles_(kReleaseCycles),
      temperature_(kAmbient) {
  state_.width = sensors.width;
  state_.temperature = static_cast<std::uint16_t>(kAmbient);
}

HandStart Gripper::Start(const HandCommand& command) noexcept {
  HandStart start{0, FindBadValue(command, state_.max_width)};
  if (start.bad) return start;
  start.ticket = outcomes_.Begin();
  std::visit([this](const auto& one) { Take(one); }, command);
  return start;
}

void Gripper::Take(const hand::Homing& /*homing*/) noexcept {
  BeginMotion(Phase::kClosing, -kBeyondStop, kHomingSpeed, kHomingForce);
}

void Gripper::Take(const hand::Move& move) noexcept {
  const double most = state_.max_width > 0 ? state_.max_width : kHandStroke;
  BeginMotion(Phase::kMoving, std::min(move.width, most), move.speed, kMotionForce);
}

void Gripper::Take(const hand::Grasp& grasp) noexcept {
  grasp_ = grasp;
  const bool from_within = sensors_.width < grasp.width - grasp.epsilon_inner;
  BeginMotion(Phase::kApproaching, from_within ? kHandStroke + kBeyondStop : -kBeyondStop,
              grasp.speed, grasp.force);
}

void Gripper::Take(const hand::Stop& /*stop*/) noexcept {
  Relax();
  End(HandResult::kSuccess);
}

void Gripper::BeginMotion(Phase phase, double target, double speed, double force) noexcept {
  phase_ = phase;
  phase_cycles_ = 0;
  slow_cycles_ = 0;
  contact_cycles_ = 0;
  width_d_ = sensors_.width;
  target_ = target;
  speed_ = std::min(speed, kMostSpeed);
  force_limit_ = force;
  direction_ = target < sensors_.width ? -1 : 1;
}

void Gripper::Relax() noexcept {
  phase_ = Phase::kHolding;
  phase_cycles_ = 0;
  force_limit_ = kMotionForce;
}

HandDrive Gripper::Cycle(const HandSensors& sensors) noexcept {
  sensors_ = sensors;
  Count();
  Advance();
  const HandDrive drive = Drive();
  Report(drive.force);
  return drive;
}

void Gripper::Count() noexcept {
  const auto count = [](int& cycles, bool holds) {
    cycles = holds ? std::min(cycles + 1, kMostCounted) : 0;
  };
  const double slow_speed = std::max(kSlowShare * speed_, kLeastSlowSpeed);
  const bool slow = direction_ * sensors_.dwidth <= slow_speed;
  const double contact_force = std::min(kContactForce, force_limit_ / 2);
  count(phase_cycles_, true);
  count(slow_cycles_, slow);
  count(contact_cycles_, slow && direction_ * sensors_.force >= contact_force);
  count(still_cycles_, std::abs(sensors_.dwidth) <= kStillSpeed);
}

void Gripper::Advance() noexcept {
  switch (phase_) {
    case Phase::kHolding: return;
    case Phase::kMoving: return AdvanceMove();
    case Phase::kApproaching:
      if (!InContact()) return;
      phase_ = Phase::kPressing;
      phase_cycles_ = 0;
      pressed_ = std::clamp(direction_ * sensors_.force, 0.0, grasp_.force);
      return;
    case Phase::kPressing: return AdvancePressing();
    case Phase::kClosing:
    case Phase::kOpening: return AdvanceHoming();
  }
}

void Gripper::AdvanceMove() noexcept {
  const bool there = std::abs(sensors_.width - target_) <= kArrivedWithin;
  if (there && still_cycles_ > 0 && width_d_ == target_) {
    phase_ = Phase::kHolding;
    phase_cycles_ = kReleaseCycles;  // nothing is released
    return End(HandResult::kSuccess);
  }
  if (slow_cycles_ < kMoveTimeout) return;
  Relax();
  End(HandResult::kFail);
}

void Gripper::AdvanceHoming() noexcept {
  if (!InContact() || still_cycles_ < kSettledCycles) return;
  if (phase_ == Phase::kClosing) {
    if (sensors_.width <= kClosedWidth) {
      return BeginMotion(Phase::kOpening, kHandStroke + kBeyondStop, kHomingSpeed, kHomingForce);
    }
    Relax();
    return End(HandResult::kFail);
  }
  state_.max_width = sensors_.width;
  Relax();
  End(HandResult::kSuccess);
}

void Gripper::AdvancePressing() noexcept {
  if (!outcomes_.is_running()) return;
  if (pressed_ == grasp_.force && still_cycles_ >= kSettledCycles) {
    End(InsideBand() ? HandResult::kSuccess : HandResult::kUnsuccessful);
  } else if (phase_cycles_ >= kGraspTimeout) {
    End(HandResult::kFail);
  }
}

bool Gripper::InsideBand() const noexcept {
  return sensors_.width > grasp_.width - grasp_.epsilon_inner &&
         sensors_.width < grasp_.width + grasp_.epsilon_outer;
}

bool Gripper::Grasped() const noexcept {
  return phase_ == Phase::kPressing && InsideBand() && still_cycles_ >= kGraspedCycles &&
         direction_ * sensors_.force >= grasp_.force / 2;
}

HandDrive Gripper::Drive() noexcept {
  if (phase_ == Phase::kPressing) return Press();
  if (phase_ != Phase::kHolding) return Servo();
  if (phase_cycles_ < kReleaseCycles) {
    width_d_ = target_ = sensors_.width;
    return {0, sensors_.width};
  }
  return Servo();
}

HandDrive Gripper::Servo() noexcept {
  const double to_go = target_ - width_d_;
  const double ahead = Clamp(to_go, speed_ * kCycleSeconds);
  const double lead = 2 * force_limit_ / kStiffness;  // more would only wind up
  const double width_d = ahead == to_go ? target_ : width_d_ + ahead;
  width_d_ = std::clamp(width_d, sensors_.width - lead, sensors_.width + lead);
  const double dwidth_d = width_d_ == width_d ? ahead / kCycleSeconds : 0;
  const double force =
      kStiffness * (width_d_ - sensors_.width) / 2 + kDamping * (dwidth_d - sensors_.dwidth) / 2;
  return {Clamp(force, force_limit_), width_d_};
}

HandDrive Gripper::Press() noexcept {
  pressed_ = std::min(grasp_.force, pressed_ + grasp_.force / kRiseCycles);
  const double dx = direction_ * sensors_.dwidth / 2;
  const double share = std::min(1.0, 1 - dx / kRacingSpeed);
  return {direction_ * Clamp(pressed_ * share, grasp_.force), sensors_.width};
}

void Gripper::Report(double force) noexcept {
  const double load = force / kRatedForce;
  const double settled = kAmbient + kHeating * load * load;
  temperature_ += kCycleSeconds / kWarmUpSeconds * (settled - temperature_);
  ++state_.message_id;
  state_.width = sensors_.width;
  state_.is_grasped = Grasped();
  state_.temperature = static_cast<std::uint16_t>(std::lround(temperature_));
}

}  // namespace twin::onboard
