#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "twin/core/hand_command.h"
#include "twin/core/realtime.h"
#include "twin/core/robot_state.h"
#include "twin/fci/protocol.h"

// Encodes and decodes the four datagrams of the Franka Control Interface, field by field from one
// table of {field, offset} (src/fci/datagram_fields.h). The compiler checks its offsets and sizes.
// Source: FCI protocol 5, robot state, robot command, gripper state, vacuum gripper state.
//
// Threads: any. Real-time: all calls are noexcept and do not allocate.
namespace twin::fci {

using StateBytes = std::array<std::byte, kStateBytes>;
using CommandBytes = std::array<std::byte, kCommandBytes>;
/// Room for a command of either protocol.
using AnyCommandBytes = std::array<std::byte, kCommand10Bytes>;
using HandStateBytes = std::array<std::byte, kHandStateBytes>;
using VacuumStateBytes = std::array<std::byte, kVacuumStateBytes>;

/// Reason why a datagram is rejected.
enum class DatagramFault : std::uint8_t {
  kNone,
  kSize,       ///< shorter than the structure (longer ones are cut, as clients do)
  kEnum,       ///< unknown mode or device status
  kBool,       ///< a flag that is neither 0 nor 1
  kNotFinite,  ///< NaN or infinity in a command; FieldWithoutNumber() checks states
};

/// Protocol 5. Its states lack the accelerometers.
void Encode(const RobotState& state, StateBytes& bytes) noexcept TWIN_REALTIME;
void Encode(const RobotCommand& command, CommandBytes& bytes) noexcept TWIN_REALTIME;
void Encode(const HandState& state, HandStateBytes& bytes) noexcept TWIN_REALTIME;
void Encode(const VacuumState& state, VacuumStateBytes& bytes) noexcept TWIN_REALTIME;

/// @returns the part of `bytes` that is the datagram. In protocol 10 numbers of a state but the id
/// are single precision, and the end of a command's motion stands in two flags, of the generator
/// and of the torque.
std::span<const std::byte> Encode(Protocol protocol, const RobotState& state,
                                  StateBytes& bytes) noexcept TWIN_REALTIME;
std::span<const std::byte> Encode(Protocol protocol, const RobotCommand& command,
                                  AnyCommandBytes& bytes) noexcept TWIN_REALTIME;

/// @param state, command  written only on success.
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   RobotState& state) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   RobotCommand& command) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   HandState& state) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(std::span<const std::byte> bytes,
                                   VacuumState& state) noexcept TWIN_REALTIME;

/// Protocol 10: either of a command's two flags ends its motion.
[[nodiscard]] DatagramFault Decode(Protocol protocol, std::span<const std::byte> bytes,
                                   RobotState& state) noexcept TWIN_REALTIME;
[[nodiscard]] DatagramFault Decode(Protocol protocol, std::span<const std::byte> bytes,
                                   RobotCommand& command) noexcept TWIN_REALTIME;

/// @returns Franka's name (null-terminated) of the first field with NaN or infinity in a state;
/// empty if all numbers are finite.
[[nodiscard]] std::string_view FieldWithoutNumber(const RobotState& state) noexcept TWIN_REALTIME;

/// Snake case: "size", ...
[[nodiscard]] std::string_view Name(DatagramFault fault) noexcept;

}  // namespace twin::fci
