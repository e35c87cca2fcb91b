#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "twin/core/joint_vector.h"
#include "twin/core/time.h"

namespace twin::record {

/// A force and its point of application, in world axes.
struct PointForce {
  Vector3 p_W{};      ///< m
  Vector3 force_W{};  ///< N
};

/// Ground truth of a simulated run for rendering: positions of all bodies and contact forces, which
/// no robot can report. Trivially copyable and bounded, so that it passes a ring without
/// allocation.
struct SceneRecord {
  static constexpr std::size_t kMostPositions = 96;
  static constexpr std::size_t kMostContacts = 16;
  static constexpr std::size_t kMostPushes = 4;

  Time at{};
  std::uint32_t positions = 0;                      ///< of the model
  std::uint32_t contacts = 0;                       ///< number stored
  std::uint32_t pushes = 0;                         ///< number stored
  std::array<double, kMostPositions> qpos{};        ///< in the model's order; m, rad, quaternions
  std::array<PointForce, kMostContacts> contact{};  ///< force on the body of the larger id
  std::array<PointForce, kMostPushes> push{};       ///< by a perturbation

  [[nodiscard]] std::span<const double> Positions() const noexcept {
    return std::span(qpos).first(positions);
  }
  [[nodiscard]] std::span<const PointForce> Contacts() const noexcept {
    return std::span(contact).first(contacts);
  }
  [[nodiscard]] std::span<const PointForce> Pushes() const noexcept {
    return std::span(push).first(pushes);
  }
};

}  // namespace twin::record
