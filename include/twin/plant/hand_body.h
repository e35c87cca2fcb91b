#pragma once

#include <cstdint>

#include "twin/core/hand_interface.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// What is mounted on the flange.
enum class HandKind : std::uint8_t {
  kNone,
  kFrankaHand,  ///< the Franka hand: two fingers on slides, driven as one
};

/// The hand's body: force in, motion of the fingers out. It moves with its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class HandBody {
 public:
  virtual ~HandBody() = default;

  /// What the drive does from the next Step() of the plant on, until told otherwise. After
  /// Plant::Reset(): nothing.
  virtual void Drive(const HandDrive& drive) noexcept TWIN_REALTIME = 0;

  /// The sensors after the last Step() or Reset(). Reset() leaves the hand open.
  [[nodiscard]] virtual const HandSensors& sensors() const noexcept = 0;
};

}  // namespace twin::plant
