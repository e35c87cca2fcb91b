#include "twin/teleop/command_peaks.h"

#include <algorithm>
#include <cstddef>

#include "twin/model/transform.h"

namespace twin::teleop {
namespace {

void Raise(Peaks& most, const Peaks& now) noexcept {
  most.speed = std::max(most.speed, now.speed);
  most.acceleration = std::max(most.acceleration, now.acceleration);
  most.jerk = std::max(most.jerk, now.jerk);
}

void Raise(CommandPeaks& most, const std::array<Peaks, 4>& now) noexcept {
  Raise(most.along, now[0]);
  Raise(most.about, now[1]);
  Raise(most.ahead, now[2]);
  Raise(most.turning, now[3]);
}

}  // namespace

Peaks PeakWatch::Track::Next(const Eigen::Vector3d& v_now, double T) noexcept {
  const Eigen::Vector3d a_now = (v_now - v) / T;
  const Peaks now{v_now.norm(), a_now.norm(), ((a_now - a) / T).norm()};
  v = v_now;
  a = a_now;
  return now;
}

void PeakWatch::Begin(const Transform& O_T_EE) noexcept {
  *this = PeakWatch();
  O_T_EE_ = O_T_EE;
}

void PeakWatch::Look(const reference::PoseTarget& target, const BaseTwist& base, double T,
                     bool is_switch, bool is_stopped) noexcept {
  const std::array<Eigen::Vector3d, 4> v{
      (model::Position(target.O_T_EE) - model::Position(O_T_EE_)) / T,
      model::TurnBetween(O_T_EE_, target.O_T_EE) / T, Eigen::Vector3d(base.v, 0, 0),
      Eigen::Vector3d(0, 0, base.w)};
  O_T_EE_ = target.O_T_EE;
  std::array<Peaks, 4> now{};
  if (is_stopped) tracks_[2] = tracks_[3] = {};
  const std::size_t counted = is_stopped ? 2 : now.size();
  for (std::size_t i = 0; i < counted; ++i) now[i] = tracks_[i].Next(v[i], T);
  Raise(all_, now);
  if (is_switch) Raise(at_switch_, now);
}

}  // namespace twin::teleop
