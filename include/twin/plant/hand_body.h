#pragma once

#include <cstdint>

#include "twin/core/hand_interface.h"
#include "twin/core/realtime.h"

namespace twin::plant {

/// Hand on the flange.
enum class HandKind : std::uint8_t {
  kNone,
  kFrankaHand,  ///< the Franka Hand: two fingers on slides with one drive
};

/// The hand's body: force in, motion of the fingers out. It advances in its plant's Step().
///
/// Threads: the plant's. Real-time: noexcept, allocates nothing.
class HandBody {
 public:
  virtual ~HandBody() = default;

  /// Sets the drive from the plant's next Step() on, until the next call. Plant::Reset() sets zero.
  virtual void Drive(const HandDrive& drive) noexcept TWIN_REALTIME = 0;

  /// Sensors after the last Step() or Reset(). Reset() leaves the hand open.
  [[nodiscard]] virtual const HandSensors& sensors() const noexcept = 0;
};

}  // namespace twin::plant
