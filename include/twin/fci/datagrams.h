#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/fci/protocol.h"

// The three datagrams of the Franka Control Interface: their bytes, both ways. A datagram is
// written and read field by field from one table of {field, offset} (src/fci/datagram_fields.h),
// whose offsets and sizes are checked by the compiler. Source: FCI protocol 5, robot state, robot
// command, gripper state.
//
// Threads: any. Real-time: all calls are noexcept and allocate nothing.
namespace twin::fci {

using StateBytes = std::array<std::byte, kStateBytes>;
using CommandBytes = std::array<std::byte, kCommandBytes>;
using HandStateBytes = std::array<std::byte, kHandStateBytes>;

/// What is wrong with a datagram.
enum class DatagramFault : std::uint8_t {
  kNone,
  kSize,       ///< shorter than the structure (longer ones are cut, as clients do)
  kEnum,       ///< a mode that does not exist
  kBool,       ///< a flag that is neither 0 nor 1
  kNotFinite,  ///< NaN or infinity in a command; of states FieldWithoutNumber() tells
};

void Encode(const RobotState& state, StateBytes& bytes) noexcept TWIN_REALTIME;
void Encode(const RobotCommand& command, CommandBytes& bytes) noexcept TWIN_REALTIME;
void Encode(const HandState& state, HandStateBytes& bytes) noexcept TWIN_REALTIME;

/// @param state, command  written only when nothing is wrong.
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   RobotState& state) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   RobotCommand& command) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   HandState& state) noexcept TWIN_REALTIME;

/// The first field of a state that holds NaN or infinity, as Franka calls it, ended by a null;
/// empty when every number is one.
[[nodiscard]] std::string_view FieldWithoutNumber(const RobotState& state) noexcept TWIN_REALTIME;

/// In snake case: "size", ...
[[nodiscard]] std::string_view Name(DatagramFault fault) noexcept;

}  // namespace twin::fci
