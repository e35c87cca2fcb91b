#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "twin/core/hand_command.h"
#include "twin/core/time.h"

// Constants of the Franka Control Interface, protocols 5 and 10. All wire data is packed and
// little-endian. Source: FCI protocol 5, transport, framing, commands; FCI protocol 10: headers of
// libfranka 0.18 to 0.21 (models/robots/fr3/README.md).
namespace twin::fci {

/// Version of the arm's protocol. The hand's is the same beside both.
enum class Protocol : std::uint16_t {
  k5 = 5,    ///< of the Panda
  k10 = 10,  ///< of the FR3: numbers of requests and statuses differ, states are single precision
};

inline constexpr std::uint16_t kArmPort = 1337;
inline constexpr std::uint16_t kHandPort = 1338;
inline constexpr std::uint16_t kVacuumPort = 1339;
inline constexpr std::uint16_t kHandVersion = 3;
inline constexpr std::uint16_t kVacuumVersion = 1;

/// TCP port and version of a device on the flange.
[[nodiscard]] constexpr std::uint16_t PortOf(HandDevice device) noexcept {
  return device == HandDevice::kCobotPump ? kVacuumPort : kHandPort;
}
[[nodiscard]] constexpr std::uint16_t VersionOf(HandDevice device) noexcept {
  return device == HandDevice::kCobotPump ? kVacuumVersion : kHandVersion;
}

/// Datagram sizes, bytes; those of arm states and commands by protocol.
inline constexpr std::size_t kStateBytes = 2373;
inline constexpr std::size_t kCommandBytes = 370;
inline constexpr std::size_t kState10Bytes = 1377;
inline constexpr std::size_t kCommand10Bytes = 371;
inline constexpr std::size_t kHandStateBytes = 23;
inline constexpr std::size_t kVacuumStateBytes = 16;

/// As it stands in Connect.
[[nodiscard]] constexpr std::uint16_t VersionOf(Protocol protocol) noexcept {
  return static_cast<std::uint16_t>(protocol);
}

[[nodiscard]] constexpr std::size_t StateBytesOf(Protocol protocol) noexcept {
  return protocol == Protocol::k5 ? kStateBytes : kState10Bytes;
}
[[nodiscard]] constexpr std::size_t CommandBytesOf(Protocol protocol) noexcept {
  return protocol == Protocol::k5 ? kCommandBytes : kCommand10Bytes;
}

/// Head sizes of TCP frames, bytes; a head's size field counts head and payload.
inline constexpr std::size_t kArmHeadBytes = 12;
inline constexpr std::size_t kHandHeadBytes = 10;
/// Largest frame of each direction except the answers to LoadModelLibrary and GetRobotModel, bytes.
inline constexpr std::size_t kLargestArmRequest = 428;
inline constexpr std::size_t kLargestHandRequest = 50;
/// Largest accepted answer to LoadModelLibrary and GetRobotModel, bytes.
inline constexpr std::size_t kLargestModelLibrary = std::size_t{16} << 20;

/// Requests to the arm. Values are those of protocol 5 on the wire, NumberOf() has those of both.
enum class ArmCommand : std::uint32_t {
  kConnect = 0,
  kMove = 1,
  kStopMove = 2,
  kGetCartesianLimit = 3,
  kSetCollisionBehavior = 4,
  kSetJointImpedance = 5,
  kSetCartesianImpedance = 6,
  kSetGuidingMode = 7,
  kSetEEToK = 8,
  kSetNEToEE = 9,
  kSetLoad = 10,
  kSetFilters = 11,
  kAutomaticErrorRecovery = 12,
  kLoadModelLibrary = 13,
  kGetRobotModel = 14,  ///< protocol 10 alone
};

inline constexpr std::uint32_t kArmCommands = 14;  ///< of protocol 5

/// The request's number on the wire; nullopt when the protocol has no such request.
[[nodiscard]] std::optional<std::uint32_t> NumberOf(Protocol protocol, ArmCommand command) noexcept;
/// The request with this number on the wire; nullopt when there is none.
[[nodiscard]] std::optional<ArmCommand> ArmCommandAt(Protocol protocol,
                                                     std::uint32_t number) noexcept;

/// Requests to the hand.
enum class HandCommandId : std::uint16_t {
  kConnect = 0,
  kHoming = 1,
  kGrasp = 2,
  kMove = 3,
  kStop = 4,
};
inline constexpr std::uint16_t kHandCommands = 5;

/// Requests to the vacuum gripper; framed, and answered, as the hand's.
enum class VacuumCommandId : std::uint16_t {
  kConnect = 0,
  kVacuum = 1,
  kDropOff = 2,
  kStop = 3,
};
inline constexpr std::uint16_t kVacuumCommands = 4;

/// Answers to Connect, of arm, hand and vacuum gripper.
enum class ConnectStatus : std::uint8_t { kSuccess = 0, kIncompatibleLibraryVersion = 1 };

/// Answers to LoadModelLibrary; GetRobotModel's success has the same number.
enum class ModelLibraryStatus : std::uint8_t { kSuccess = 0, kError = 1 };

/// Machine for which a model library is requested.
enum class Architecture : std::uint8_t { kX64 = 0, kX86 = 1, kArm = 2, kArm64 = 3 };
enum class OperatingSystem : std::uint8_t { kLinux = 0, kWindows = 1 };

/// Names as clients of the real robot print them: "Connect", "Move", "Stop Move", ...
[[nodiscard]] std::string_view Name(ArmCommand command) noexcept;
/// "Connect", "Homing", "Grasp", "Move", "Stop".
[[nodiscard]] std::string_view Name(HandCommandId command) noexcept;
/// "Connect", "Vacuum", "Drop Off", "Stop".
[[nodiscard]] std::string_view Name(VacuumCommandId command) noexcept;

/// Timeouts of a client. All are finite: a silent robot causes an error message, not a hang.
struct ClientTimeout {
  Duration connect = std::chrono::seconds(3);  ///< for the connection and the answer to Connect
  /// For the answer to a request; StopMove and recovery answer once the arm is at rest.
  Duration answer = std::chrono::seconds(10);
  Duration state = std::chrono::seconds(1);  ///< between states; as in libfranka
};

}  // namespace twin::fci
