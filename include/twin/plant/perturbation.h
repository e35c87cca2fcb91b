#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

// Scripted external forces, in plant time (zero at Plant::Reset, 1 ms per step) or in the time
// since a motion started: the same in lockstep and in real time. Simultaneous forces add up, also
// on one body.
namespace twin::plant {

/// Axes of a force.
enum class ForceFrame : std::uint8_t {
  kWorld,  ///< fixed axes
  kBody,   ///< rotate with the body
};

/// A person's push: a force and a torque at a point of a body, which rise, hold and fall.
///
///   w(t) = s((t - begin) / rise) w              while it rises,  s(x) = 10 x^3 - 15 x^4 + 6 x^5
///        = w                                    between
///        = s((begin + duration - t) / rise) w   while it falls; zero before and after
///
/// s is the minimum-jerk path typical of people (Flash and Hogan 1985). The value at the middle of
/// a step applies to the whole step.
struct Push {
  std::string body;  ///< of the compiled model: "panda_hand", "panda_link4", or from the scene
  Duration begin{};  ///< plant time, or since the motion began, >= 0
  /// Number of the motion since Plant::Reset from which `begin` counts, >= 1; without such a motion
  /// the force never acts. Absent: `begin` is plant time.
  std::optional<std::uint32_t> motion = std::nullopt;
  Duration duration = std::chrono::milliseconds(300);  ///< rise and fall included, > 0
  Duration rise = std::chrono::milliseconds(100);      ///< and fall; in [0, duration / 2]
  Vector3 force{};                                     ///< N, each in [-10000, 10000]
  Vector3 torque{};  ///< Nm, each in [-10000, 10000]; added to the force's moment
  Vector3 point{};   ///< of application, body frame, m, each in [-100, 100]
  ForceFrame frame = ForceFrame::kWorld;  ///< of force and torque
  bool operator==(const Push&) const = default;
};

/// A person's hand that holds a point of a body by a spring and leads it along a line.
///
///   F = K (r - p) + D (dr - dp),   cut to |F| <= largest_force
///   r(t) = from + s((t - begin) / duration) by
///
/// p is the point of the body and r that of the hand, in the world; s as in Push. The hand grips at
/// `begin` and releases at begin + duration.
struct HandSpring {
  std::string body;                                    ///< as in Push
  Vector3 point{};                                     ///< body frame, m, each in [-100, 100]
  Duration begin{};                                    ///< as in Push
  std::optional<std::uint32_t> motion = std::nullopt;  ///< as in Push
  Duration duration = std::chrono::seconds(1);         ///< > 0
  /// World, m. Absent: the point's position at the grip, so that it does not jerk.
  std::optional<Vector3> from = std::nullopt;
  Vector3 by{};               ///< displacement of the hand, world axes, m
  double stiffness = 1000;    ///< K, N/m, in [0, 20000]
  double damping = 30;        ///< D, Ns/m, in [0, 500]
  double largest_force = 50;  ///< N, in [0, 10000]
  bool operator==(const HandSpring&) const = default;
};

using Perturbation = std::variant<Push, HandSpring>;

/// Checks everything that needs no model. @throws InputError naming field, value and range.
void Validate(const Perturbation& perturbation);

/// Share of a push's force at `t`, on the clock of its begin, in [0, 1].
///
/// Threads: any. Real-time: noexcept.
[[nodiscard]] double ShareAt(const Push& push, Duration t) noexcept;

/// The body on which it acts.
[[nodiscard]] const std::string& BodyOf(const Perturbation& perturbation) noexcept;

}  // namespace twin::plant
