#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// What a wheel stands on: the sum of its contacts.
struct WheelLoad {
  double force = 0;  ///< normal, N; zero: it touches nothing
  Vector3 point{};   ///< where it acts, from the wheel's centre, world axes, m
  Vector3 normal{};  ///< out of the ground, world axes, unit
};

/// The friction of a tyre on ground that does not move: bristles that bend before they slide.
///
///   dz/dt = v - |u| z / sigma,   f = -(k z + c v),   |f| <= mu N
///
/// v is how fast the tyre slips over the ground where they touch, u how fast it rolls over it; both
/// lie in the ground's plane, as z, the bend of the bristles, does. Where mu N would be exceeded
/// the tyre slides: f has that size, and z is what the bristles then keep (k z = -f). At rest it
/// holds without any creep; rolling forgets what bent it within sigma. The tangential spring that
/// slides is Cundall and Strack's (A discrete numerical model for granular assemblies, 1979), the
/// length sigma that of the brush tyre (Pacejka, Tyre and Vehicle Dynamics, chapter 3).
///
/// Why not the engine's own friction: its soft cones push a contact that slips out of the ground,
/// by mu b v / g of its load where b is its damping; the wheels of a vehicle that turns by skidding
/// slip all the time, lose the ground and chatter, and the arm on it with them.
///
/// Threads: one thread. Real-time: noexcept, allocates nothing.
class Tyre {
 public:
  // Decisions of ours, as such figures are not published: rubber on a smooth floor; a tyre that
  // bends sideways by 5 mm under a quarter of the vehicle; damped about half critically.
  static constexpr double kFriction = 0.7;    // mu
  static constexpr double kStiffness = 5e4;   // k, N/m
  static constexpr double kDamping = 1000;    // c, N s/m
  static constexpr double kRelaxation = 0.1;  // sigma, m

  void Reset() noexcept { bend_ = {}; }

  /// One millisecond on.
  /// @param slip  v, world axes, m/s; its part along the normal does not count.
  /// @param rolling  |u|, m/s. @returns f, world axes, N; zero without a load.
  [[nodiscard]] Vector3 Step(const WheelLoad& load, const Vector3& slip,
                             double rolling) noexcept TWIN_REALTIME;

 private:
  Vector3 bend_{};  ///< z, world axes, m
};

}  // namespace twin::plant
