#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"
#include "twin/fci/protocol.h"

// Encodes and decodes the TCP frames of the Franka Control Interface: requests and answers of arm,
// hand and vacuum gripper. Source: FCI protocol 5, TCP commands, gripper, vacuum gripper.
namespace twin::fci {

// A message's kName is its name as clients of the real robot print it.

/// Opens a session with the arm or the hand.
struct Connect {
  static constexpr std::string_view kName = "Connect";
  std::uint16_t version = 0;
  std::uint16_t udp_port = 0;  ///< port on which the client receives states
  bool operator==(const Connect&) const = default;
};

/// Permitted deviation of a motion from its path or goal: translation m, rotation rad, elbow rad.
struct Deviation {
  double translation = 10.0;
  double rotation = 3.12;
  double elbow = 6.283185307179586;
  bool operator==(const Deviation&) const = default;
};

/// Requests a motion. The defaults are libfranka's and mean no limit.
struct Move {
  static constexpr std::string_view kName = "Move";
  MotionModes modes;
  Deviation maximum_path_deviation;
  Deviation maximum_goal_pose_deviation;
  /// Protocol 10: whether commands are goals, as MotionModes::asynchronous; and the largest joint
  /// velocities towards them, rad/s.
  bool asynchronous = false;
  JointVector maximum_velocity{};
};

struct StopMove {
  static constexpr std::string_view kName = "Stop Move";
};
struct AutomaticErrorRecovery {
  static constexpr std::string_view kName = "Automatic Error Recovery";
};

/// Requests a virtual wall.
struct GetCartesianLimit {
  static constexpr std::string_view kName = "Get Cartesian Limit";
  std::int32_t id = 0;
};

struct LoadModelLibrary {
  static constexpr std::string_view kName = "Load Model Library";
  Architecture architecture = Architecture::kX64;
  OperatingSystem system = OperatingSystem::kLinux;
};

/// Requests the robot's URDF. Protocol 10.
struct GetRobotModel {
  static constexpr std::string_view kName = "Get Robot Model";
};

using ArmRequest = std::variant<Connect, Move, StopMove, GetCartesianLimit, Setting,
                                AutomaticErrorRecovery, LoadModelLibrary, GetRobotModel>;

/// Connect, or a command to the hand or the vacuum gripper.
using HandRequest = std::variant<Connect, HandCommand>;

/// A virtual wall, as reported by the robot.
struct CartesianLimit {
  Vector3 object_world_size{};
  Transform object_frame = kIdentityTransform;
  bool object_activation = false;
};

/// Head of a frame, arm or hand.
struct FrameHead {
  /// Number of an ArmCommand; HandCommandId or VacuumCommandId. May be unknown.
  std::uint32_t command = 0;
  std::uint32_t command_id = 0;
  std::uint32_t size = 0;  ///< bytes of head and payload
};

/// A received frame.
struct Frame {
  FrameHead head;
  std::span<const std::byte> payload;  ///< points into the reader's buffer
};

/// Why a request's payload is malformed; capture and server show it to users.
struct BadFrame {
  std::string what;  ///< "Move: 55 bytes of payload, 56 are needed", ...
};

/// Decodes a request; its size must match exactly. A well-formed payload with a value out of range
/// is not a BadFrame, because the robot refuses such values: NaN in a setting and an unknown
/// machine in LoadModelLibrary pass. An unknown mode in a Move becomes ControllerMode::kOther or
/// MotionGeneratorMode::kIdle, which INT refuses as an invalid argument. Threads: any. May
/// allocate, for the text only.
[[nodiscard]] std::variant<ArmRequest, BadFrame> ParseArmRequest(const Frame& frame,
                                                                 Protocol protocol = Protocol::k5);
[[nodiscard]] std::variant<HandRequest, BadFrame> ParseHandRequest(const Frame& frame);
[[nodiscard]] std::variant<HandRequest, BadFrame> ParseVacuumRequest(const Frame& frame);

/// The command that identifies the request on the wire.
[[nodiscard]] ArmCommand CommandOf(const ArmRequest& request) noexcept;

/// Encodes a whole frame. A Move with kOther or kIdle gets a number that no mode uses.
/// @pre the protocol has the request.
[[nodiscard]] std::vector<std::byte> EncodeRequest(std::uint32_t command_id,
                                                   const ArmRequest& request,
                                                   Protocol protocol = Protocol::k5);
[[nodiscard]] std::vector<std::byte> EncodeRequest(std::uint32_t command_id,
                                                   const HandRequest& request);
/// For the vacuum gripper. @pre  for both: the device has the command.
[[nodiscard]] std::vector<std::byte> EncodeVacuumRequest(std::uint32_t command_id,
                                                         const HandRequest& request);

/// A status' number on the wire: in protocol 10 statuses for safety functions stand between those
/// that protocol 5 has. The inverse is TakeStatus().
[[nodiscard]] std::uint8_t StatusNumber(Protocol protocol, ArmCommand command,
                                        std::uint8_t status) noexcept;
/// @returns the status of protocol 5 that `number` means; that of a rejection or an abortion by a
/// safety function is the nearest one there. An unknown number stays unknown.
[[nodiscard]] std::uint8_t TakeStatus(Protocol protocol, ArmCommand command,
                                      std::uint8_t number) noexcept;

/// Encodes an arm's answer that is only a status. @param command  the answered command.
/// @param status  its number in protocol 5. @pre the protocol has the command.
[[nodiscard]] std::vector<std::byte> EncodeArmAnswer(ArmCommand command, std::uint32_t command_id,
                                                     std::uint8_t status,
                                                     Protocol protocol = Protocol::k5);
/// Encodes Connect's answer. @param version  the server's.
[[nodiscard]] std::vector<std::byte> EncodeArmConnectAnswer(std::uint32_t command_id,
                                                            ConnectStatus status,
                                                            std::uint16_t version);
[[nodiscard]] std::vector<std::byte> EncodeCartesianLimitAnswer(std::uint32_t command_id,
                                                                SetterStatus status,
                                                                const CartesianLimit& limit);
/// Encodes GetRobotModel's answer: success and the URDF.
[[nodiscard]] std::vector<std::byte> EncodeRobotModelAnswer(std::uint32_t command_id,
                                                            std::string_view urdf);
/// Encodes LoadModelLibrary's answer. @param library  its bytes; empty unless success.
[[nodiscard]] std::vector<std::byte> EncodeModelLibraryAnswer(std::uint32_t command_id,
                                                              ModelLibraryStatus status,
                                                              std::span<const std::byte> library);
/// Encodes an answer of hand or vacuum gripper. @param command  the request's number, of either.
[[nodiscard]] std::vector<std::byte> EncodeHandAnswer(HandCommandId command,
                                                      std::uint32_t command_id, HandResult result);
[[nodiscard]] std::vector<std::byte> EncodeHandConnectAnswer(std::uint32_t command_id,
                                                             ConnectStatus status,
                                                             std::uint16_t version);

/// The arm's answer: a status and its data.
struct ArmAnswer {
  std::uint8_t status = 0;    ///< its number in protocol 5
  std::uint16_t version = 0;  ///< Connect
  CartesianLimit limit;       ///< GetCartesianLimit
  /// LoadModelLibrary and GetRobotModel: library or URDF; points into the frame's payload.
  std::span<const std::byte> library;
};
/// The answer of hand or vacuum gripper.
struct HandAnswer {
  HandResult result = HandResult::kFail;  ///< Connect: kSuccess, or kFail for another version
  std::uint16_t version = 0;              ///< Connect
};
/// Decodes an answer as libfranka does: ignores the frame's command, takes the request from
/// command_id, and ignores surplus bytes. An unknown status is a BadFrame for the hand; for the arm
/// the caller checks it.
/// @param asked  the request with the frame's command_id.
[[nodiscard]] std::variant<ArmAnswer, BadFrame> ParseArmAnswer(ArmCommand asked, const Frame& frame,
                                                               Protocol protocol = Protocol::k5);
[[nodiscard]] std::variant<HandAnswer, BadFrame> ParseHandAnswer(HandCommandId asked,
                                                                 const Frame& frame);
[[nodiscard]] std::variant<HandAnswer, BadFrame> ParseHandAnswer(VacuumCommandId asked,
                                                                 const Frame& frame);

}  // namespace twin::fci
