#include "application/scripted_operator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "twin/model/transform.h"

namespace twin::application {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;
using teleop::Mode;
using teleop::OperatorSample;

constexpr Duration kLookPeriod = milliseconds(33);
constexpr Duration kSamplePeriod = milliseconds(5);
constexpr Duration kHandTime = milliseconds(2200);  ///< for the fingers to open or close
constexpr Duration kPressTime = milliseconds(300);
constexpr int kMostTries = 40;  ///< motions for one intent

constexpr double kFingertips = 0.1034;  // m, from the hand's frame
constexpr double kClear = 0.09;    // m, from the object's upper face to the fingertips above it
constexpr double kGrip = 0.015;    // m, of the fingertips above the object's middle
constexpr double kCoarse = 0.005;  // m, tolerances of reaching
constexpr double kNear = 0.004;    // at half the speed
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

const Vector3d kUp(0, 0, 1);

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

const std::array<ScriptedOperator::Intent, 17> ScriptedOperator::kIntents{{
    {"switching to the base", [](auto& me, auto&, Time t) { return me.Lead(Mode::kBase, t); }},
    {"driving to the object",
     [](auto& me, auto& s, Time t) { return me.Drive(me.AtObject(), s, t); }},
    {"switching to the arm", [](auto& me, auto&, Time t) { return me.Lead(Mode::kArm, t); }},
    {"reaching over the object",
     [](auto& me, auto& s, Time t) {
       const double above = me.task_.height / 2 + kClear;
       return me.Reach(s.object + above * kUp - s.hand, s, kCoarse, t);
     }},
    {"reaching the object",
     [](auto& me, auto& s, Time t) {
       me.lifted_from_ = s.object[2];
       return me.Reach(s.object + kGrip * kUp - s.hand, s, kNear, t);
     }},
    {"closing the hand", [](auto& me, auto&, Time t) { return me.TurnHand(true, t); }},
    {"lifting the object",
     [](auto& me, auto& s, Time t) {
       return me.Reach((me.lifted_from_ + 0.12 - s.object[2]) * kUp, s, kLoose, t);
     }},
    {"lifting it up to carry",
     [](auto& me, auto& s, Time t) {
       if (s.object[2] < me.lifted_from_ + 0.05) me.GiveUp();
       return me.Reach(s.arm + s.R_WO * kCarried - s.hand, s, kLoose, t);
     }},
    {"switching to the base", [](auto& me, auto&, Time t) { return me.Lead(Mode::kBase, t); }},
    {"backing off",
     [](auto& me, auto& s, Time t) {
       BasePose away = me.AtObject();
       away.x -= 0.8 * std::cos(away.yaw);
       away.y -= 0.8 * std::sin(away.yaw);
       return me.Drive(away, s, t);
     }},
    {"driving to the target",
     [](auto& me, auto& s, Time t) { return me.Drive(me.AtTarget(), s, t); }},
    {"switching to the arm", [](auto& me, auto&, Time t) { return me.Lead(Mode::kArm, t); }},
    {"reaching over the target",
     [](auto& me, auto& s, Time t) {
       return me.Reach(me.target() + 0.06 * kUp - s.object, s, kCoarse, t);
     }},
    {"setting the object down",
     [](auto& me, auto& s, Time t) { return me.Reach(me.target() - s.object, s, kNear, t); }},
    {"opening the hand", [](auto& me, auto&, Time t) { return me.TurnHand(false, t); }},
    {"leaving the object",
     [](auto& me, auto& s, Time t) {
       const double up = me.task_.to[2] + me.task_.height / 2 + kClear - s.hand[2];
       return me.Reach(up * kUp, s, kLoose, t);
     }},
    {"ending",
     [](auto& me, auto&, Time t) { return me.Press(&OperatorSample::end_presses, kPressTime, t); }},
}};

std::string ScriptedOperator::failure() const {
  if (!gave_up_at_) return "";
  return fmt::format("the person gave up while {}", kIntents.at(*gave_up_at_).text);
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
  if (kIntents.at(intent_).pursue(*this, Blurred(seen), now)) {
    intent_ = std::min(intent_ + 1, kIntents.size() - 1);
    tries_ = 0;
    has_pressed_ = false;
    return;
  }
  if (++tries_ > kMostTries) GiveUp();
}

void ScriptedOperator::GiveUp() noexcept {
  if (!gave_up_at_) gave_up_at_ = intent_;
  intent_ = kIntents.size() - 1;
  tries_ = 0;
  has_pressed_ = false;
}

bool ScriptedOperator::Lead(Mode mode, Time now) noexcept {
  return felt_.mode == mode || Press(&OperatorSample::mode_presses, kPressTime, now);
}

bool ScriptedOperator::TurnHand(bool closed, Time now) noexcept {
  return felt_.hand_closed == closed || Press(&OperatorSample::gripper_presses, kHandTime, now);
}

bool ScriptedOperator::Press(std::uint32_t OperatorSample::*counter, Duration least,
                             Time now) noexcept {
  if (!has_pressed_) ++(sample_.*counter);
  has_pressed_ = true;
  Wait(least, now);
  return false;
}

bool ScriptedOperator::Reach(const Vector3d& path, const Sight& sight, double tolerance,
                             Time now) noexcept {
  if (path.norm() <= tolerance) return true;
  Vector3d missed = path * (1 + Noise(config_.hand_noise));
  for (Eigen::Index i = 0; i < 3; ++i) missed[i] += path.norm() * Noise(config_.hand_noise / 2);
  Axes axes = Axes::Zero();
  axes.head<3>() = sight.R_WO.transpose() * missed;
  const double speed = tolerance == kNear ? config_.arm_speed / 2 : config_.arm_speed;
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
  const bool drives = felt_.mode == Mode::kBase;
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
