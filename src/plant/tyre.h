#pragma once

#include "twin/core/joint_vector.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// Ground contact of a wheel: the sum of its contacts.
struct WheelLoad {
  double force = 0;  ///< normal, N; zero: no contact
  Vector3 point{};   ///< of application, from the wheel's centre, world axes, m
  Vector3 normal{};  ///< away from the ground, world axes, unit
};

/// Friction of a tyre on static ground: bristles that bend before they slide.
///
///   dz/dt = v - |u| z / sigma,   f = -(k z + c v),   |f| <= mu N
///
/// v is the slip velocity of the tyre at the contact, u the rolling velocity; both lie in the
/// ground's plane, as does z, the bend of the bristles. Where mu N would be exceeded the tyre
/// slides: f has that magnitude, and z is the bend that remains (k z = -f). At rest it holds
/// without creep; rolling removes the bend within sigma. The sliding tangential spring is Cundall
/// and Strack's (A discrete numerical model for granular assemblies, 1979), the length sigma that
/// of the brush tyre (Pacejka, Tyre and Vehicle Dynamics, chapter 3).
///
/// The engine's own friction is unsuitable: its soft cones lift a slipping contact off the ground,
/// by mu b v / g of its load with b its damping. The wheels of a skid-steered vehicle slip all the
/// time, lose contact and chatter, and so does the arm.
///
/// Threads: one thread. Real-time: noexcept, allocates nothing.
class Tyre {
 public:
  // Decisions, as such values are not published: rubber on a smooth floor; 5 mm of sideways bend
  // under a quarter of the vehicle; about half of critical damping.
  static constexpr double kFriction = 0.7;    // mu
  static constexpr double kStiffness = 5e4;   // k, N/m
  static constexpr double kDamping = 1000;    // c, N s/m
  static constexpr double kRelaxation = 0.1;  // sigma, m

  void Reset() noexcept { bend_ = {}; }

  /// Advances by 1 ms.
  /// @param slip  v, world axes, m/s; its normal component is ignored.
  /// @param rolling  |u|, m/s. @returns f, world axes, N; zero without a load.
  [[nodiscard]] Vector3 Step(const WheelLoad& load, const Vector3& slip,
                             double rolling) noexcept TWIN_REALTIME;

 private:
  Vector3 bend_{};  ///< z, world axes, m
};

}  // namespace twin::plant
