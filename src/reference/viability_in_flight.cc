#include "twin/reference/viability_in_flight.h"

#include <optional>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::reference {
namespace {

int Checked(int in_flight, int held) {
  if (in_flight < 0 || in_flight > ViabilityInFlight::kMostInFlight) {
    throw InputError(
        fmt::format("viability filter: {} commands in flight; the number must be in [0, {}]",
                    in_flight, ViabilityInFlight::kMostInFlight));
  }
  if (held < in_flight) {
    throw InputError(
        fmt::format("viability filter: {} cycles to bridge with {} commands in flight; there must "
                    "be at least as many",
                    held, in_flight));
  }
  return in_flight;
}

/// Interpretation of a joint's command: a position or a velocity.
struct Position {
  static double Of(const AxisState& x) noexcept { return x.q; }
  static double Jerk(const AxisState& x, double c) noexcept {
    return ViableAxis::JerkToPosition(x, c);
  }
};
struct Velocity {
  static double Of(const AxisState& x) noexcept { return x.dq; }
  static double Jerk(const AxisState& x, double c) noexcept {
    return ViableAxis::JerkToVelocity(x, c);
  }
};

/// The possible states of a joint; the first one assumes that all commands have arrived.
template <typename Command>
class Possible {
 public:
  Possible(const AxisState& x, std::span<const InFlight> since, std::size_t joint) noexcept {
    states_[0].x = x;
    for (const InFlight& cycle : since) {
      const std::size_t before = count_;
      for (std::size_t i = 0; i < before; ++i) {
        AxisState& state = states_[i].x;
        const AxisState held = ViableAxis::Step(state, 0);
        if (cycle.sent) {
          states_[count_++].x = held;
          state = ViableAxis::Step(state, Command::Jerk(state, cycle.c[joint]));
        } else {
          state = held;
        }
      }
    }
    const double hold = Command::Of(ViableAxis::Step(states_[0].x, 0));
    for (std::size_t i = 1; i < count_; ++i) states_[i].extra = Command::Jerk(states_[i].x, hold);
  }

  [[nodiscard]] std::span<const PossibleState> all() const noexcept {
    return std::span(states_).first(count_);
  }
  [[nodiscard]] const AxisState& first() const noexcept { return states_[0].x; }

 private:
  std::array<PossibleState, 1U << ViabilityInFlight::kMostInFlight> states_{};
  std::size_t count_ = 1;
};

/// @returns the command for a joint: the requested one if admissible, else a replacement; nullopt
/// if none is admissible.
template <typename Command>
std::optional<double> Nearest(const ViableAxis& axis, const Possible<Command>& possible,
                              double wish) noexcept {
  const double wished = Command::Jerk(possible.first(), wish);
  const std::optional<double> jerk = axis.NearestOfAll(possible.all(), wished);
  if (!jerk) return {};
  return *jerk == wished ? wish : Command::Of(ViableAxis::Step(possible.first(), *jerk));
}

}  // namespace

ViabilityInFlight::ViabilityInFlight(const JointLimits& limits, int in_flight, int held)
    : filter_(limits, held), in_flight_(Checked(in_flight, held)) {}

int ViabilityInFlight::most_lost() const noexcept {
  return (filter_.axis(0).lost() - in_flight_) / (in_flight_ + 1);
}

ViabilityInFlight::Outcome ViabilityInFlight::NextOn(Interface interface, const JointVector& q_d,
                                                     const JointVector& dq_d,
                                                     const JointVector& ddq_d,
                                                     std::span<const InFlight> since,
                                                     const JointVector& wish) const noexcept {
  if (since.size() > static_cast<std::size_t>(in_flight_)) return {};
  Outcome outcome{.send = true, .c = wish};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const AxisState x{q_d[i], dq_d[i], ddq_d[i]};
    const std::optional<double> c =
        interface == Interface::kPosition
            ? Nearest(axis(i), Possible<Position>(x, since, i), wish[i])
            : Nearest(axis(i), Possible<Velocity>(x, since, i), wish[i]);
    if (!c) return {};
    outcome.active[i] = *c != wish[i];
    outcome.c[i] = *c;
  }
  return outcome;
}

ViabilityInFlight::Outcome ViabilityInFlight::Next(const JointVector& q_d, const JointVector& dq_d,
                                                   const JointVector& ddq_d,
                                                   std::span<const InFlight> since,
                                                   const JointVector& q_c) const noexcept {
  return NextOn(Interface::kPosition, q_d, dq_d, ddq_d, since, q_c);
}

ViabilityInFlight::Outcome ViabilityInFlight::NextVelocity(const JointVector& q_d,
                                                           const JointVector& dq_d,
                                                           const JointVector& ddq_d,
                                                           std::span<const InFlight> since,
                                                           const JointVector& dq_c) const noexcept {
  return NextOn(Interface::kVelocity, q_d, dq_d, ddq_d, since, dq_c);
}

}  // namespace twin::reference
