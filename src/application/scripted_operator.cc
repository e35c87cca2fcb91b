#include "application/teleoperation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

#include "twin/model/transform.h"

namespace twin::application {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;
using teleop::OperatorSample;

constexpr Duration kLookPeriod = milliseconds(33);
constexpr Duration kSamplePeriod = milliseconds(5);
constexpr Duration kHandTime = milliseconds(2200);  ///< for the fingers to open or close
constexpr int kMostTries = 40;                      ///< motions for one intent

constexpr double kFingertips = 0.1034;  // m, from the hand's frame
constexpr double kClear = 0.09;    // m, from the object's upper face to the fingertips above it
constexpr double kGrip = 0.015;    // m, of the fingertips above the object's middle
constexpr double kCoarse = 0.005;  // m, tolerances of reaching
constexpr double kNear = 0.004;
constexpr double kLoose = 0.03;
constexpr double kThere = 0.03;          // m, of driving
constexpr double kTurned = 0.03;         // rad
constexpr double kBehind = 2.1;          // rad: goals beyond this heading are reached backwards
const Vector3d kCarried(0.42, 0, 0.42);  // m, of the fingertips in O

/// Ratio of peak and mean velocity of a minimum-jerk motion.
constexpr double kPeak = 1.875;

double Wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

Vector3d VectorOf(const Vector3& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

ScriptedOperator::ScriptedOperator(const plant::TruthProbe& truth, const FetchTask& task,
                                   const ScriptedOperatorConfig& config,
                                   const teleop::TeleoperatorConfig& robot, std::uint64_t seed)
    : task_(task),
      config_(config),
      robot_(robot),
      random_(seed, RandomStream::kOperator),
      base_(truth, "husky_base_link"),
      arm_(truth, "panda_link0"),
      hand_(truth, "panda_hand"),
      object_(truth, task.object) {}

std::string ScriptedOperator::failure() const {
  if (!gave_up_at_) return "";
  constexpr std::array<std::string_view, 17> kNames{"switching to the base",
                                                    "driving to the object",
                                                    "switching to the arm",
                                                    "reaching over the object",
                                                    "reaching the object",
                                                    "closing the hand",
                                                    "lifting the object",
                                                    "lifting it up to carry",
                                                    "switching to the base",
                                                    "backing off",
                                                    "driving to the target",
                                                    "switching to the arm",
                                                    "reaching over the target",
                                                    "setting the object down",
                                                    "opening the hand",
                                                    "leaving the object",
                                                    "ending"};
  return fmt::format("the person gave up while {}",
                     kNames.at(static_cast<std::size_t>(*gave_up_at_)));
}

double ScriptedOperator::Noise(double sigma) noexcept {
  return sigma * random_.Normal(++draws_);
}

std::optional<OperatorSample> ScriptedOperator::Read(Time now) noexcept {
  if (now >= next_look_) Look(now);
  if (now < next_sample_) return std::nullopt;
  next_sample_ = now + kSamplePeriod;
  Act(now);
  ++sample_.sequence;
  sample_.at = now;
  return sample_;
}

void ScriptedOperator::Look(Time now) noexcept {
  next_look_ = now + kLookPeriod;
  const Transform X_WB = base_.Pose();
  const Transform X_WO = arm_.Pose();
  const Transform X_WH = hand_.Pose();
  Sight& sight = sights_[looks_++ % kSights];
  sight.at = now;
  sight.base = {X_WB[12], X_WB[13], std::atan2(X_WB[1], X_WB[0])};
  sight.R_WO = model::Orientation(X_WO).toRotationMatrix();
  sight.arm = model::Position(X_WO);
  sight.hand = model::Position(X_WH) + kFingertips * Vector3d(X_WH[8], X_WH[9], X_WH[10]);
  sight.object = model::Position(object_.Pose());
}

bool ScriptedOperator::Seen(Time before, Sight& sight) const noexcept {
  const std::size_t count = std::min(looks_, kSights);
  for (std::size_t back = 1; back <= count; ++back) {
    const Sight& candidate = sights_[(looks_ - back) % kSights];
    if (candidate.at > before) continue;
    sight = candidate;
    return true;
  }
  return false;
}

ScriptedOperator::Sight ScriptedOperator::Blurred(const Sight& sight) noexcept {
  Sight seen = sight;
  for (Eigen::Index i = 0; i < 3; ++i) {
    seen.hand[i] += Noise(config_.eye_noise);
    seen.object[i] += Noise(config_.eye_noise);
  }
  seen.base.x += Noise(config_.far_noise);
  seen.base.y += Noise(config_.far_noise);
  seen.base.yaw += Noise(config_.far_noise);
  return seen;
}

bool ScriptedOperator::IsStill(Time now) const noexcept {
  constexpr Duration kSpan = milliseconds(200);
  constexpr double kStill = 0.002;  // m, rad
  Sight late;
  Sight early;
  if (!Seen(now - config_.reaction, late) || !Seen(now - config_.reaction - kSpan, early)) {
    return false;
  }
  return (late.hand - early.hand).norm() < kStill &&
         std::hypot(late.base.x - early.base.x, late.base.y - early.base.y) < kStill &&
         std::abs(Wrapped(late.base.yaw - early.base.yaw)) < kStill;
}

void ScriptedOperator::Act(Time now) noexcept {
  if (doing_ == Doing::kMoving) {
    Move(now);
    return;
  }
  sample_.axes = {};
  if (doing_ == Doing::kWaiting && felt_.echo >= await_ && now >= wait_until_ && IsStill(now)) {
    doing_ = Doing::kDeciding;
  }
  if (doing_ == Doing::kDeciding) Decide(now);
}

void ScriptedOperator::Decide(Time now) noexcept {
  Sight seen;
  if (!Seen(now - config_.reaction, seen)) return;
  if (Pursue(Blurred(seen), now)) {
    intent_ =
        intent_ == Intent::kEnd ? intent_ : static_cast<Intent>(static_cast<int>(intent_) + 1);
    tries_ = 0;
    has_pressed_ = false;
    return;
  }
  if (++tries_ > kMostTries) GiveUp();
}

void ScriptedOperator::GiveUp() noexcept {
  if (!gave_up_at_) gave_up_at_ = intent_;
  intent_ = Intent::kEnd;
  tries_ = 0;
  has_pressed_ = false;
}

bool ScriptedOperator::Pursue(const Sight& s, Time now) noexcept {
  const Vector3d up(0, 0, 1);
  const Vector3d target = VectorOf(task_.to);
  const bool leads_base = felt_.mode == teleop::Mode::kBase;
  switch (intent_) {
    case Intent::kLeadBase:
    case Intent::kLeadBaseAgain: return Press(&OperatorSample::mode_presses, leads_base, now);
    case Intent::kLeadArm:
    case Intent::kLeadArmAgain: return Press(&OperatorSample::mode_presses, !leads_base, now);
    case Intent::kDriveToObject: return Drive(StandFor(task_.from, task_.from_yaw), s, now);
    case Intent::kBackOff: {
      BasePose away = StandFor(task_.from, task_.from_yaw);
      away.x -= 0.8 * std::cos(away.yaw);
      away.y -= 0.8 * std::sin(away.yaw);
      return Drive(away, s, now);
    }
    case Intent::kDriveToTarget: return Drive(StandFor(task_.to, task_.to_yaw), s, now);
    case Intent::kOverObject:
      return Reach(s.object + (task_.height / 2 + kClear) * up - s.hand, s, kCoarse, now);
    case Intent::kAtObject:
      lifted_from_ = s.object[2];
      return Reach(s.object + kGrip * up - s.hand, s, kNear, now);
    case Intent::kClose: return Press(&OperatorSample::gripper_presses, felt_.hand_closed, now);
    case Intent::kLift: return Reach((lifted_from_ + 0.12 - s.object[2]) * up, s, kLoose, now);
    case Intent::kCarry:
      if (s.object[2] < lifted_from_ + 0.05) GiveUp();
      return Reach(s.arm + s.R_WO * kCarried - s.hand, s, kLoose, now);
    case Intent::kOverTarget: return Reach(target + 0.06 * up - s.object, s, kCoarse, now);
    case Intent::kAtTarget: return Reach(target - s.object, s, kNear, now);
    case Intent::kOpen: return Press(&OperatorSample::gripper_presses, !felt_.hand_closed, now);
    case Intent::kLeave:
      return Reach((target[2] + task_.height / 2 + kClear - s.hand[2]) * up, s, kLoose, now);
    case Intent::kEnd: return Press(&OperatorSample::end_presses, false, now);
  }
  return true;
}

bool ScriptedOperator::Press(std::uint32_t OperatorSample::*counter, bool is_so,
                             Time now) noexcept {
  if (is_so) return true;
  if (!has_pressed_) ++(sample_.*counter);
  has_pressed_ = true;
  const bool is_hand = counter == &OperatorSample::gripper_presses;
  Wait(is_hand ? kHandTime : Duration(milliseconds(300)), now);
  return false;
}

bool ScriptedOperator::Reach(const Vector3d& path, const Sight& sight, double tolerance,
                             Time now) noexcept {
  if (path.norm() <= tolerance) return true;
  Vector3d missed = path * (1 + Noise(config_.hand_noise));
  for (Eigen::Index i = 0; i < 3; ++i) missed[i] += path.norm() * Noise(config_.hand_noise / 2);
  Axes axes = Axes::Zero();
  axes.head<3>() = sight.R_WO.transpose() * missed;
  const bool is_careful = intent_ == Intent::kAtObject || intent_ == Intent::kAtTarget;
  const double speed = is_careful ? config_.arm_speed / 2 : config_.arm_speed;
  Begin(axes, std::max(0.6, kPeak * missed.norm() / speed), now);
  return false;
}

bool ScriptedOperator::Drive(const BasePose& goal, const Sight& sight, Time now) noexcept {
  const double dx = goal.x - sight.base.x;
  const double dy = goal.y - sight.base.y;
  const double c = std::cos(sight.base.yaw);
  const double s = std::sin(sight.base.yaw);
  const double ahead = c * dx + s * dy;
  const double left = -s * dx + c * dy;
  const double turn = Wrapped(goal.yaw - sight.base.yaw);
  // Turns towards a goal that is not ahead before driving, unless the goal is near.
  const bool is_far = std::hypot(ahead, left) > 4 * kThere;
  const double direct = std::atan2(left, ahead);
  const double bearing = std::abs(direct) > kBehind ? std::atan2(-left, -ahead) : direct;
  Axes path = Axes::Zero();
  if (is_far && std::abs(bearing) > 2 * kTurned) {
    path[5] = bearing;
  } else if (is_far || std::abs(ahead) > kThere) {
    path[0] = ahead;
  } else if (std::abs(turn) > kTurned) {
    path[5] = turn;
  } else {
    return true;
  }
  path *= 1 + Noise(config_.hand_noise);
  const double duration = std::max({1.6, kPeak * std::abs(path[0]) / config_.base_speed,
                                    kPeak * std::abs(path[5]) / config_.base_turn});
  Begin(path, duration, now);
  return false;
}

void ScriptedOperator::Begin(const Axes& path, double duration, Time now) noexcept {
  doing_ = Doing::kMoving;
  path_ = path;
  duration_ = duration;
  begun_ = now;
  ++motions_;
}

void ScriptedOperator::Wait(Duration least, Time now) noexcept {
  doing_ = Doing::kWaiting;
  await_ = sample_.sequence + 1;  // the next sample
  wait_until_ = now + least;
}

void ScriptedOperator::Move(Time now) noexcept {
  const double s = ToSeconds(now - begun_) / duration_;
  if (s >= 1) {
    sample_.axes = {};
    Wait(config_.reaction, now);
    return;
  }
  const Axes velocity = path_ * (30 * s * s * (1 - s) * (1 - s) / duration_);
  const bool drives = felt_.mode == teleop::Mode::kBase;
  const double full_speed = drives ? robot_.ahead.speed : robot_.along.speed;
  const double full_turn = drives ? robot_.turning.speed : robot_.about.speed;
  for (std::size_t i = 0; i < sample_.axes.size(); ++i) {
    sample_.axes[i] =
        Deflection(velocity[static_cast<Eigen::Index>(i)], i < 3 ? full_speed : full_turn);
    if (sample_.axes[i] != 0) sample_.axes[i] += Noise(config_.tremor);
  }
}

double ScriptedOperator::Deflection(double velocity, double full) const noexcept {
  const double dead = robot_.mapping.dead_zone;
  if (velocity == 0) return 0;
  return std::copysign(dead + (1 - dead) * std::min(std::abs(velocity) / full, 1.0), velocity);
}

BasePose ScriptedOperator::StandFor(const Vector3& place, double yaw) const noexcept {
  const double away = task_.reach + task_.mount;
  return {place[0] - away * std::cos(yaw), place[1] - away * std::sin(yaw), yaw};
}

}  // namespace twin::application
