#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "twin/core/time.h"

// Constants of the Franka Control Interface, protocol 5. All wire data is packed and little-endian.
// Source: FCI protocol 5, transport, framing, commands.
namespace twin::fci {

inline constexpr std::uint16_t kArmPort = 1337;
inline constexpr std::uint16_t kHandPort = 1338;
inline constexpr std::uint16_t kArmVersion = 5;
inline constexpr std::uint16_t kHandVersion = 3;

/// Datagram sizes, bytes.
inline constexpr std::size_t kStateBytes = 2373;
inline constexpr std::size_t kCommandBytes = 370;
inline constexpr std::size_t kHandStateBytes = 23;

/// Head sizes of TCP frames, bytes; a head's size field counts head and payload.
inline constexpr std::size_t kArmHeadBytes = 12;
inline constexpr std::size_t kHandHeadBytes = 10;
/// Largest frame of each direction except LoadModelLibrary's answer, bytes.
inline constexpr std::size_t kLargestArmRequest = 428;
inline constexpr std::size_t kLargestHandRequest = 50;
/// Largest accepted answer to LoadModelLibrary, bytes.
inline constexpr std::size_t kLargestModelLibrary = std::size_t{16} << 20;

/// Requests to the arm.
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
};
inline constexpr std::uint32_t kArmCommands = 14;

/// Requests to the hand.
enum class HandCommandId : std::uint16_t {
  kConnect = 0,
  kHoming = 1,
  kGrasp = 2,
  kMove = 3,
  kStop = 4,
};
inline constexpr std::uint16_t kHandCommands = 5;

/// Answers to Connect, of arm and hand.
enum class ConnectStatus : std::uint8_t { kSuccess = 0, kIncompatibleLibraryVersion = 1 };

/// Answers to LoadModelLibrary.
enum class ModelLibraryStatus : std::uint8_t { kSuccess = 0, kError = 1 };

/// Machine for which a model library is requested.
enum class Architecture : std::uint8_t { kX64 = 0, kX86 = 1, kArm = 2, kArm64 = 3 };
enum class OperatingSystem : std::uint8_t { kLinux = 0, kWindows = 1 };

/// Names as clients of the real robot print them: "Connect", "Move", "Stop Move", ...
[[nodiscard]] std::string_view Name(ArmCommand command) noexcept;
/// "Connect", "Homing", "Grasp", "Move", "Stop".
[[nodiscard]] std::string_view Name(HandCommandId command) noexcept;

/// Timeouts of a client. All are finite: a silent robot causes an error message, not a hang.
struct ClientTimeout {
  Duration connect = std::chrono::seconds(3);  ///< for the connection and the answer to Connect
  /// For the answer to a request; StopMove and recovery answer once the arm is at rest.
  Duration answer = std::chrono::seconds(10);
  Duration state = std::chrono::seconds(1);  ///< between states; as in libfranka
};

}  // namespace twin::fci
