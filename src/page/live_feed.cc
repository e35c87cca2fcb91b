#include "twin/page/live_feed.h"

#include <chrono>

#include "twin/plant/observers.h"
#include "twin/rt/host_time.h"

namespace twin::page {
namespace {

constexpr Duration kViewPeriod = std::chrono::milliseconds(17);
/// Largest lag that a run makes up for after the machine was busy.
constexpr Duration kMostHurry = std::chrono::milliseconds(100);

void Fill(const record::CycleRecord& record, std::uint64_t served, std::uint64_t held,
          ArmView& view) {
  const RobotState& state = record.state;
  view.at = record.at;
  view.q = state.q;
  view.dq = state.dq;
  view.tau_J = state.tau_J;
  view.follows_reference = state.controller_mode != ControllerMode::kExternalController;
  view.q_d = state.q_d;
  view.dq_d = state.dq_d;
  view.ddq_d = state.ddq_d;
  view.O_F_ext_hat_K = state.O_F_ext_hat_K;
  view.O_T_EE = state.O_T_EE;
  view.mode = state.robot_mode;
  view.errors = state.errors;
  view.reflex_reason = state.reflex_reason;
  view.base = record.base;
  view.served = served;
  view.held = held;
}

}  // namespace

void LiveFeed::Put(const record::CycleRecord& record) noexcept {
  if (next_ != nullptr) next_->Put(record);
  served_ += record.fate == record::CommandFate::kServed ? 1 : 0;
  held_ += record.fate == record::CommandFate::kHeld ? 1 : 0;
  if (record.at >= next_view_) {
    next_view_ = record.at + kViewPeriod;
    arm_.PublishWith([&](ArmView& view) { Fill(record, served_, held_, view); });
    if (truth_ != nullptr) {
      const auto capture = [&](record::SceneRecord& scene) {
        plant::CaptureScene(record.at, *truth_, scene);
      };
      scene_.PublishWith(capture);
      shown_.PublishWith(capture);
      places_.PublishWith(capture);
    }
  }
  if (wall_ != nullptr) Wait(record.at);
}

void LiveFeed::Put(const record::TickRecord& record) noexcept {
  if (next_ != nullptr) next_->Put(record);
}

void LiveFeed::Wait(Time now) noexcept {
  while (is_paused() && !(interrupted_ != nullptr && *interrupted_)) {
    rt::SleepUntil(*wall_, wall_->Now() + kViewPeriod);
    behind_.reset();  // time goes on from here
  }
  const Duration wall = wall_->Now().time_since_epoch();
  if (!behind_) behind_ = wall - now.time_since_epoch();
  if (wall - now.time_since_epoch() > *behind_ + kMostHurry) {
    behind_ = wall - now.time_since_epoch() - kMostHurry;
  }
  rt::SleepUntil(*wall_, now + *behind_);
}

}  // namespace twin::page
