#include "twin/reference/viable_axis.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"

namespace twin::reference {
namespace {

/// Distance of the enforced bounds from the given ones: shares, and rad at the range's ends.
constexpr double kInside = 1e-6;

/// Halvings of the jerk range: the rest is 1e-10 of it.
constexpr int kHalvings = 34;

AxisBounds KeptOf(const AxisBounds& given) {
  return {.q_min = given.q_min + kInside,
          .q_max = given.q_max - kInside,
          .dq_max = given.dq_max * (1 - kInside),
          .ddq_max = given.ddq_max * (1 - kInside),
          .dddq_max = given.dddq_max * (1 - kInside),
          .velocity_offset = given.velocity_offset,
          .deceleration = given.deceleration};
}

void RequireSound(const AxisBounds& bounds, int lost, std::string_view name) {
  RequireMagnitude(name, "dq_max", bounds.dq_max);
  RequireMagnitude(name, "ddq_max", bounds.ddq_max);
  RequireMagnitude(name, "dddq_max", bounds.dddq_max);
  if (!(std::isfinite(bounds.q_min) && std::isfinite(bounds.q_max) &&
        bounds.q_min < bounds.q_max)) {
    throw InputError(fmt::format("viability filter: {}: the range [{}, {}] rad is none", name,
                                 bounds.q_min, bounds.q_max));
  }
  for (const auto& [field, value] : {std::pair{"velocity_offset", bounds.velocity_offset},
                                     {"deceleration", bounds.deceleration}}) {
    if (std::isfinite(value) && value >= 0) continue;
    throw InputError(
        fmt::format("viability filter: {}: {} is {}; it must not be negative", name, field, value));
  }
  RequireLost(lost);
}

}  // namespace

ViableAxis::ViableAxis(const AxisBounds& bounds, int lost, std::string_view name)
    : lost_((RequireSound(bounds, lost, name), lost)), kept_(KeptOf(bounds)) {
  // Rounds until a = -A, in which the velocity rises, and rounds that bring it back to zero.
  const double per_round = (lost_ + 1) * kT * kept_.ddq_max;
  const double turns = std::ceil(2 * kept_.ddq_max / (kT * kept_.dddq_max)) + 1;
  constexpr double kMostRounds = 1e5;
  const double rounds = turns + std::ceil((kept_.dq_max + turns * per_round) / per_round) + 2;
  if (rounds > kMostRounds) {
    throw InputError(fmt::format(
        "viability filter: {}: to stop from full speed takes {:.3g} commands; more than {:.0g} are "
        "no bounds of a joint",
        name, rounds, kMostRounds));
  }
  rounds_ = static_cast<int>(rounds);
  longest_way_ = ReachOf(kept_.dq_max, kept_.ddq_max).q;
  const Reach from_rest = ReachOf(0, kept_.ddq_max);
  least_range_ = from_rest.q;
  if (kept_.deceleration > 0) {
    // At each end nothing moves towards it, not by rounding either.
    const double still = kept_.velocity_offset * kept_.velocity_offset / (2 * kept_.deceleration);
    least_range_ = std::max(least_range_, still) + std::max(ReachOf(from_rest.dq, 0).q, still);
  }
  RequireNoConflict(from_rest.dq, name);
}

/// Requires that no jerk violates an upper and a lower bound at once.
void ViableAxis::RequireNoConflict(double gathered, std::string_view name) const {
  const double range = kept_.q_max - kept_.q_min;
  if (range < least_range_) {
    throw InputError(fmt::format(
        "viability filter: {}: in a range of {:.4g} rad it may have to brake both ways at once "
        "after {} lost commands; at least {:.4g} rad are needed at these limits. Lower its "
        "acceleration",
        name, range + 2 * kInside, lost_, least_range_ + 2 * kInside));
  }
  if (kept_.dq_max < gathered) {
    throw InputError(fmt::format(
        "viability filter: {}: its velocity limit of {:.4g} rad/s is gathered within {} lost "
        "commands; at least {:.4g} rad/s are needed at these limits. Lower its acceleration",
        name, kept_.dq_max, lost_, gathered));
  }
}

AxisState ViableAxis::Step(const AxisState& x, double jerk) noexcept {
  AxisState next;
  next.ddq = x.ddq + kT * jerk;
  next.dq = x.dq + kT * next.ddq;
  next.q = x.q + kT * next.dq;
  return next;
}

double ViableAxis::JerkToPosition(const AxisState& x, double q_c) noexcept {
  return (((q_c - x.q) / kT - x.dq) / kT - x.ddq) / kT;
}

double ViableAxis::JerkToVelocity(const AxisState& x, double dq_c) noexcept {
  return ((dq_c - x.dq) / kT - x.ddq) / kT;
}

double ViableAxis::NeedOfStep(double dq) const noexcept {
  if (!(dq > 0)) return 0;
  const double v = dq + kept_.velocity_offset;
  return v * v / (2 * kept_.deceleration);
}

double ViableAxis::NeedOfHeld(double dq, double ddq) const noexcept {
  const double step = kT * ddq;
  const auto need = [&](double i) {
    return kT * (i - 1) * (dq + step * i / 2) + NeedOfStep(dq + step * i);
  };
  if (ddq >= 0) return lost_ > 0 ? need(lost_) : 0;
  const double last = std::min<double>(lost_, std::ceil(-dq / step) - 1);  // that still rises
  if (last < 1) return 0;
  double most = std::max(need(1), need(last));
  // Gentler than the limit shrinks, the need is a parabola that is open downwards.
  const double share = ddq / kept_.deceleration;
  if (share <= -1) return most;
  const double peak =
      std::floor((step / 2 - dq - (dq + kept_.velocity_offset) * share) / (step * (1 + share)));
  for (const double i : {peak, peak + 1}) most = std::max(most, need(std::clamp(i, 1.0, last)));
  return most;
}

ViableAxis::Reach ViableAxis::ReachOf(double dq, double ddq) const noexcept {
  const double n = lost_;
  const bool shrinks = kept_.deceleration > 0;
  Reach reach{0, dq};
  if (shrinks && dq > 0) reach.q = std::max(0.0, NeedOfStep(dq) - kT * dq);
  double q = 0;
  for (int round = 0; round < rounds_ && (dq > 0 || ddq > 0); ++round) {
    if (ddq < 0 && dq > 0) {  // the highest point may be in the held cycles
      const double peak = std::min(n, std::floor(-dq / (kT * ddq)));
      reach.q = std::max(reach.q, q + kT * peak * (dq + kT * ddq * (peak + 1) / 2));
    }
    if (shrinks) reach.q = std::max(reach.q, q + NeedOfHeld(dq, ddq));
    q += kT * n * (dq + kT * ddq * (n + 1) / 2);
    dq += kT * n * ddq;
    reach.q = std::max(reach.q, q);
    reach.dq = std::max(reach.dq, dq);
    ddq = std::max(ddq - kT * kept_.dddq_max, -kept_.ddq_max);
    dq += kT * ddq;
    if (shrinks) reach.q = std::max(reach.q, q + NeedOfStep(dq));
    q += kT * dq;
    reach.q = std::max(reach.q, q);
    reach.dq = std::max(reach.dq, dq);
  }
  return reach;
}

bool ViableAxis::KeepsUpper(const AxisState& x) const noexcept {
  if (!(x.q <= kept_.q_max && x.dq <= kept_.dq_max)) return false;
  const Reach reach = ReachOf(x.dq, x.ddq);
  return x.q + reach.q <= kept_.q_max && reach.dq <= kept_.dq_max;
}

bool ViableAxis::Keeps(Side side, const AxisState& x) const noexcept {
  if (side == Side::kUpper) return KeepsUpper(x);
  // The mirrored joint's range is [-q_max, -q_min].
  return KeepsUpper({.q = kept_.q_max + kept_.q_min - x.q, .dq = -x.dq, .ddq = -x.ddq});
}

bool ViableAxis::Contains(const AxisState& x) const noexcept {
  return std::abs(x.ddq) <= kept_.ddq_max && Keeps(Side::kUpper, x) && Keeps(Side::kLower, x);
}

JerkRange ViableAxis::Feasible(double ddq) const noexcept {
  const JerkRange range{std::max(-kept_.dddq_max, (-kept_.ddq_max - ddq) / kT),
                        std::min(kept_.dddq_max, (kept_.ddq_max - ddq) / kT)};
  if (!range.empty()) return range;
  const double back = std::clamp(-ddq / kT, -kept_.dddq_max, kept_.dddq_max);
  return {back, back};  // acceleration far beyond its bound: towards it
}

double ViableAxis::Braking(Side side, double ddq) const noexcept {
  const JerkRange range = Feasible(ddq);
  return side == Side::kUpper ? range.lowest : range.highest;
}

bool ViableAxis::KeepsAll(Side side, std::span<const PossibleState> states,
                          double jerk) const noexcept {
  return std::all_of(states.begin(), states.end(), [&](const PossibleState& state) {
    return Keeps(side, Step(state.x, jerk + state.extra));
  });
}

double ViableAxis::Bisect(Side side, std::span<const PossibleState> states, double keeps,
                          double breaks) const noexcept {
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (keeps + breaks) / 2;
    (KeepsAll(side, states, middle) ? keeps : breaks) = middle;
  }
  return keeps;
}

double ViableAxis::Nearest(const AxisState& x, double wish) const noexcept {
  const JerkRange range = Feasible(x.ddq);
  if (!std::isfinite(wish)) wish = x.dq > 0 ? range.lowest : range.highest;
  double jerk = std::clamp(wish, range.lowest, range.highest);
  const PossibleState only{.x = x};
  for (const Side side : {Side::kUpper, Side::kLower}) {
    if (Keeps(side, Step(x, jerk))) continue;
    const double braking = Braking(side, x.ddq);
    return Keeps(side, Step(x, braking)) ? Bisect(side, {&only, 1}, braking, jerk) : braking;
  }
  return jerk;
}

std::optional<double> ViableAxis::NearestOfAll(std::span<const PossibleState> states,
                                               double wish) const noexcept {
  if (states.size() == 1) return Nearest(states[0].x, wish);
  JerkRange range = Feasible(states[0].x.ddq);
  for (const PossibleState& state : states.subspan(1)) {
    const JerkRange here = Feasible(state.x.ddq);
    range.lowest = std::max(range.lowest, here.lowest - state.extra);
    range.highest = std::min(range.highest, here.highest - state.extra);
  }
  if (range.empty()) return {};
  if (!std::isfinite(wish)) wish = states[0].x.dq > 0 ? range.lowest : range.highest;
  double jerk = std::clamp(wish, range.lowest, range.highest);
  for (const Side side : {Side::kUpper, Side::kLower}) {
    if (KeepsAll(side, states, jerk)) continue;
    const double braking = side == Side::kUpper ? range.lowest : range.highest;
    if (!KeepsAll(side, states, braking)) return {};
    jerk = Bisect(side, states, braking, jerk);
  }
  // The lower bounds may require too much for the upper ones.
  if (!KeepsAll(Side::kUpper, states, jerk)) return {};
  return jerk;
}

JerkRange ViableAxis::Admissible(const AxisState& x) const noexcept {
  JerkRange range = Feasible(x.ddq);
  const JerkRange feasible = range;
  const PossibleState only{.x = x};
  for (const Side side : {Side::kUpper, Side::kLower}) {
    double& end = side == Side::kUpper ? range.highest : range.lowest;
    const double braking = side == Side::kUpper ? feasible.lowest : feasible.highest;
    if (Keeps(side, Step(x, end))) continue;
    if (!Keeps(side, Step(x, braking))) return {1, 0};
    end = Bisect(side, {&only, 1}, braking, end);
  }
  return range;
}

double ViableAxis::Margin(const AxisState& x) const noexcept {
  const Reach up = ReachOf(x.dq, x.ddq);
  const Reach down = ReachOf(-x.dq, -x.ddq);
  const double range = kept_.q_max - kept_.q_min;
  return std::min({(kept_.q_max - x.q - up.q) / range, (x.q - down.q - kept_.q_min) / range,
                   (kept_.dq_max - up.dq) / kept_.dq_max, (kept_.dq_max - down.dq) / kept_.dq_max,
                   (kept_.ddq_max - std::abs(x.ddq)) / kept_.ddq_max});
}

void RequireMagnitude(std::string_view name, std::string_view field, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw InputError(
      fmt::format("viability filter: {}: {} is {}; it must be positive", name, field, value));
}

void RequireLost(int lost) {
  if (lost >= 0 && lost <= ViableAxis::kMostLost) return;
  throw InputError(
      fmt::format("viability filter: {} commands lost in a row; the number must be in [0, {}]",
                  lost, ViableAxis::kMostLost));
}

}  // namespace twin::reference
