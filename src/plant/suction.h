#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include <mujoco/mujoco.h>

#include "plant/robot_description.h"
#include "twin/core/realtime.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// Suction cups a pump may have.
inline constexpr std::size_t kMostCups = 4;

/// The suction cups of a compiled model, on one pump.
///
/// A cup is a link with collision shapes named lip..., a ring about its z axis, which points out of
/// the cup; its face is z = 0. From each of 16 points of the ring a ray along z looks for a body
/// that the lip touches somewhere. The point is covered if the body is within 2 mm of the face: the
/// lip's give, which counts as touch, so that a cup of 36 mm seals at 3 degrees at most, and on
/// surfaces that are bent no more.
///
///   force at each covered point    f = p pi r^2 / 16, towards the cup; minus f on the cup
///   air let in                     Q_in = C A sqrt(2 p / rho),  A = A_bore (sum of the cups' open
///                                  shares + 1 if the valve is open)
///   air pumped out                 Q_out = power Q_0 (1 - p / p_max)
///   vacuum in the cups             dp/dt = (p_air / V) (Q_out - Q_in)
///
/// The contact carries what is left of the force, with the friction of a dry cup (mjcf_writer.cc):
/// so an object is pulled off when its load exceeds p pi r^2, slides when the load across exceeds
/// friction times the rest, and tilts when it acts beyond the ring. Once nothing touches the lip,
/// the cup is open and the vacuum gone within milliseconds. Whatever touches is sucked, also what
/// is fixed to the world.
///
/// Sources: Q_0 = 12 l/min and p_max = 750 mbar, Schmalz' data sheet of the CobotPump ECBPi. Ours:
/// one volume V of 30 cm^3, a bore of 4 mm as orifice of a whole cup's leak and of the valve (C
/// 0.6; both isothermal, air at 1013 mbar and 1.2 kg/m^3), the rays, the give.
///
/// Threads: one thread. Real-time: all but the constructor are noexcept and allocate nothing.
class Suction final : public SuctionBody {
 public:
  /// @param robot  with one to kMostCups cups, like the model.
  Suction(const mjModel& model, const RobotDescription& robot) noexcept;

  /// The air's pressure in the cups, the pump at rest and the valve open.
  void Reset() noexcept;
  /// Before a step, and before other forces are set: takes back those of the step before.
  void Release(mjData& data) noexcept TWIN_REALTIME;
  /// Before a step, after other forces are set: adds the forces, and advances the air by it.
  /// @pre positions and contacts in data are of the state before the step.
  void Apply(const mjModel& model, mjData& data) noexcept TWIN_REALTIME;

  void Drive(const PumpDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const PumpSensors& sensors() const noexcept override { return sensors_; }

 private:
  static constexpr std::size_t kMostTouched = 8;  ///< shapes that a cup sees at once
  struct Cup {
    int body = 0;
    double radius = 0;  ///< of the ring, m
  };
  /// Ids in the engine's model.
  template <std::size_t kSize>
  struct Ids {
    std::array<int, kSize> ids{};
    std::size_t count = 0;

    /// A full list takes no more.
    void Add(int id) noexcept {
      if (std::ranges::find(all(), id) == all().end() && count < kSize) ids[count++] = id;
    }
    [[nodiscard]] std::span<const int> all() const noexcept { return {ids.data(), count}; }
  };
  using Touched = Ids<kMostTouched>;

  [[nodiscard]] static Touched TouchedBy(const Cup& cup, const mjModel& model,
                                         const mjData& data) noexcept;
  /// Pulls what covers the cup. @returns the open share of its ring.
  double Pull(const Cup& cup, const mjModel& model, mjData& data) noexcept;
  /// @param open  shares of all cups.
  void Flow(double open) noexcept;

  std::array<Cup, kMostCups> cups_{};
  std::size_t count_ = 0;
  Ids<kMostCups*(kMostTouched + 1)> pulled_;  ///< bodies with forces of the last step
  PumpDrive drive_;
  PumpSensors sensors_;
};

}  // namespace twin::plant
