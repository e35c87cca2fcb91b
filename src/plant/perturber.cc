#include "plant/perturber.h"

#include <string>

#include <fmt/format.h>

#include "plant/applied_wrench.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

/// All bodies but the world, which is fixed.
std::string NamesOfBodies(const mjModel& model) {
  std::string names;
  for (int body = 1; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    if (name == nullptr || *name == '\0') continue;
    names += names.empty() ? "" : ", ";
    names += name;
  }
  return names;
}

/// The motion of a perturbation's origin; absent: none.
std::optional<std::uint32_t> MotionOf(const Perturbation& perturbation) noexcept {
  return std::visit([](const auto& one) { return one.motion; }, perturbation);
}

/// A perturbation's time origin after a reset of the plant.
std::optional<Duration> FirstOrigin(const Perturbation& perturbation) noexcept {
  if (MotionOf(perturbation)) return std::nullopt;
  return Duration::zero();
}

/// A vector in a body's axes, converted to world axes.
Vector3 Turned(const mjData& data, int body, const Vector3& v) noexcept {
  Vector3 turned{};
  mju_rotVecMat(turned.data(), v.data(), data.xmat + 9 * body);
  return turned;
}

Vector3 PointOf(const mjData& data, int body, const Vector3& point) noexcept {
  Vector3 p = Turned(data, body, point);
  mju_addTo3(p.data(), data.xpos + 3 * body);
  return p;
}

Vector3 VelocityOf(const mjModel& model, const mjData& data, int body, const Vector3& p) noexcept {
  mjtNum twist[6];  // [w; v] of the body's origin, world axes
  mj_objectVelocity(&model, &data, mjOBJ_XBODY, body, twist, 0);
  mjtNum arm[3];
  mju_sub3(arm, p.data(), data.xpos + 3 * body);
  Vector3 velocity{};
  mju_cross(velocity.data(), twist, arm);
  mju_addTo3(velocity.data(), twist + 3);
  return velocity;
}

}  // namespace

void Perturber::Add(const Perturbation& perturbation) {
  Validate(perturbation);
  const std::string& name = BodyOf(perturbation);
  int body = mj_name2id(model_, mjOBJ_BODY, (prefix_ + name).c_str());
  if (body <= 0) body = mj_name2id(model_, mjOBJ_BODY, name.c_str());
  if (body <= 0) {
    throw InputError(
        fmt::format("perturbation: the model has no body \"{}\" that a force could act "
                    "on; it has: {}",
                    name, NamesOfBodies(*model_)));
  }
  entries_.push_back({.what = perturbation, .body = body, .origin = FirstOrigin(perturbation)});
}

void Perturber::Clear(mjData& data) {
  ClearForces(data);
  entries_.clear();
}

void Perturber::Restart() noexcept {
  motions_ = 0;
  for (Entry& entry : entries_) {
    entry.holds = false;
    entry.origin = FirstOrigin(entry.what);
  }
}

void Perturber::BeginMotion(Duration now) noexcept {
  ++motions_;
  for (Entry& entry : entries_) {
    if (MotionOf(entry.what) == motions_) entry.origin = now;
  }
}

void Perturber::ClearForces(mjData& data) const noexcept {
  for (const Entry& entry : entries_) mju_zero(data.xfrc_applied + 6 * entry.body, 6);
}

void Perturber::Apply(Duration begin, mjData& data) noexcept {
  const Duration middle = begin + kCycle / 2;
  for (Entry& entry : entries_) {
    if (!entry.origin) continue;
    const Duration at = middle - *entry.origin;
    if (const auto* push = std::get_if<Push>(&entry.what)) {
      Act(*push, entry, at, data);
    } else {
      Act(*std::get_if<HandSpring>(&entry.what), entry, at, data);
    }
  }
}

void Perturber::Act(const Push& push, const Entry& entry, Duration at,
                    mjData& data) const noexcept {
  const double share = ShareAt(push, at);
  if (share == 0) return;
  Vector3 force = push.force;
  Vector3 torque = push.torque;
  if (push.frame == ForceFrame::kBody) {
    force = Turned(data, entry.body, force);
    torque = Turned(data, entry.body, torque);
  }
  mju_scl3(force.data(), force.data(), share);
  mju_scl3(torque.data(), torque.data(), share);
  AddWrench(force, torque, PointOf(data, entry.body, push.point), entry.body, data);
}

void Perturber::Act(const HandSpring& spring, Entry& entry, Duration at,
                    mjData& data) const noexcept {
  const Duration since = at - spring.begin;
  entry.holds = entry.holds && since < spring.duration;
  if (since < Duration::zero() || since >= spring.duration) return;
  const Vector3 p = PointOf(data, entry.body, spring.point);
  if (!entry.holds) {
    entry.from = spring.from.value_or(p);
    entry.holds = true;
  }
  const Vector3 dp = VelocityOf(*model_, data, entry.body, p);
  const double seconds = ToSeconds(spring.duration);
  const PathPoint path = MinimumJerk(ToSeconds(since) / seconds);
  Vector3 force{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double r = entry.from[i] + path.s * spring.by[i];
    const double dr = path.ds / seconds * spring.by[i];
    force[i] = spring.stiffness * (r - p[i]) + spring.damping * (dr - dp[i]);
  }
  const double size = mju_norm3(force.data());
  if (size > spring.largest_force) {
    mju_scl3(force.data(), force.data(), spring.largest_force / size);
  }
  AddWrench(force, {}, p, entry.body, data);
}

}  // namespace twin::plant
