#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

// Forces from outside, by a script in plant time (which is zero at Plant::Reset and advances 1 ms a
// step), or in the time since a motion began: the same in lockstep and in real time. Several at
// once add up, on one body as well.
namespace twin::plant {

/// The axes in which a force is written down.
enum class ForceFrame : std::uint8_t {
  kWorld,  ///< fixed, whatever the body does
  kBody,   ///< turns with the body
};

/// A push by a person: a force and a torque at a point of a body, which rise, hold and fall.
///
///   w(t) = s((t - begin) / rise) w          while it rises,     s(x) = 10 x^3 - 15 x^4 + 6 x^5
///        = w                                between
///        = s((begin + duration - t) / rise) w   while it falls; 0 outside [begin, begin +
///        duration]
///
/// s is the path of minimum jerk, as people move (Flash and Hogan 1985). The value of the middle of
/// a step acts over all of it.
struct Push {
  std::string body;  ///< of the compiled model: "panda_hand", "panda_link4", one of the scene
  Duration begin{};  ///< plant time, or since the motion began, >= 0
  /// Which motion since Plant::Reset `begin` counts from, >= 1: somebody waits until the arm begins
  /// to move. One that never comes: the force never acts. Absent: `begin` is plant time.
  std::optional<std::uint32_t> motion = std::nullopt;
  Duration duration = std::chrono::milliseconds(300);  ///< rise and fall included, > 0
  Duration rise = std::chrono::milliseconds(100);      ///< and fall; in [0, duration / 2]
  Vector3 force{};                                     ///< N, each in [-10000, 10000]
  Vector3 torque{};  ///< Nm, each in [-10000, 10000]; beside the force's own moment
  Vector3 point{};   ///< where the force acts, body frame, m, each in [-100, 100]
  ForceFrame frame = ForceFrame::kWorld;  ///< of force and torque
  bool operator==(const Push&) const = default;
};

/// A hand that holds a point of a body as by a spring, and leads it along a line.
///
///   F = K (r - p) + D (dr - dp),   cut to |F| <= largest_force
///   r(t) = from + s((t - begin) / duration) by
///
/// p is the point of the body and r the hand's, in the world; s as in Push. It takes hold at
/// `begin` and lets go at begin + duration.
struct HandSpring {
  std::string body;                                    ///< as in Push
  Vector3 point{};                                     ///< body frame, m, each in [-100, 100]
  Duration begin{};                                    ///< as in Push
  std::optional<std::uint32_t> motion = std::nullopt;  ///< as in Push
  Duration duration = std::chrono::seconds(1);         ///< > 0
  /// World, m. Absent: where the point is when the hand takes hold, so that it does not jerk.
  std::optional<Vector3> from = std::nullopt;
  Vector3 by{};               ///< how far the hand moves, world axes, m
  double stiffness = 1000;    ///< K, N/m, in [0, 20000]
  double damping = 30;        ///< D, Ns/m, in [0, 500]
  double largest_force = 50;  ///< N, in [0, 10000]
  bool operator==(const HandSpring&) const = default;
};

using Perturbation = std::variant<Push, HandSpring>;

/// Checks all that can be checked without a model. @throws InputError naming field, value and
/// range.
void Validate(const Perturbation& perturbation);

/// The share of a push's force at `t` of the time that its begin is in, in [0, 1].
///
/// Threads: any. Real-time: noexcept.
[[nodiscard]] double ShareAt(const Push& push, Duration t) noexcept;

/// The body it acts on.
[[nodiscard]] const std::string& BodyOf(const Perturbation& perturbation) noexcept;

}  // namespace twin::plant
