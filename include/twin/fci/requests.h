#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "twin/core/hand_command.h"
#include "twin/core/joint_vector.h"
#include "twin/core/modes.h"
#include "twin/core/request_status.h"
#include "twin/core/setting.h"
#include "twin/fci/protocol.h"

// The TCP frames of the Franka Control Interface, arm and hand: what is asked and what is answered,
// and their bytes, both ways. Source: FCI protocol 5, TCP commands, gripper.
namespace twin::fci {

/// Opens a session. @note of arm and hand alike.
struct Connect {
  std::uint16_t version = 0;
  std::uint16_t udp_port = 0;  ///< where the client listens for states
  bool operator==(const Connect&) const = default;
};

/// By how much a motion may miss its path or its goal: translation m, rotation rad, elbow rad.
struct Deviation {
  double translation = 10.0;
  double rotation = 3.12;
  double elbow = 6.283185307179586;
  bool operator==(const Deviation&) const = default;
};

/// Asks for a motion. The defaults are what libfranka sends, and mean no limit.
struct Move {
  MotionModes modes;
  Deviation maximum_path_deviation;
  Deviation maximum_goal_pose_deviation;
};

struct StopMove {};
struct AutomaticErrorRecovery {};

/// Asks for a virtual wall.
struct GetCartesianLimit {
  std::int32_t id = 0;
};

struct LoadModelLibrary {
  Architecture architecture = Architecture::kX64;
  OperatingSystem system = OperatingSystem::kLinux;
};

using ArmRequest = std::variant<Connect, Move, StopMove, GetCartesianLimit, Setting,
                                AutomaticErrorRecovery, LoadModelLibrary>;

/// Connect, or a command of the hand.
using HandRequest = std::variant<Connect, HandCommand>;

/// A virtual wall, as the robot tells it.
struct CartesianLimit {
  Vector3 object_world_size{};
  Transform object_frame = kIdentityTransform;
  bool object_activation = false;
};

/// Head of a frame, arm or hand.
struct FrameHead {
  std::uint32_t command = 0;  ///< ArmCommand or HandCommandId; may be none of them
  std::uint32_t command_id = 0;
  std::uint32_t size = 0;  ///< of head and payload
};

/// A frame as it came.
struct Frame {
  FrameHead head;
  std::span<const std::byte> payload;  ///< of the reader's buffer
};

/// Why a request's payload is none: to be told to people, by capture and server.
struct BadFrame {
  std::string what;  ///< "Move: 55 bytes of payload, 56 are needed", ...
};

/// Reads a request, whose size must be exact. A value that is out of its range (but whose bytes are
/// well-formed) is no BadFrame: refusing it is the robot's. So NaN in a setting is handed on, a
/// machine that does not exist in LoadModelLibrary too, and a mode that does not exist in a Move
/// becomes ControllerMode::kOther or MotionGeneratorMode::kIdle, with which no motion starts: INT
/// refuses them as an invalid argument. Threads: any. May allocate for the text only.
[[nodiscard]] std::variant<ArmRequest, BadFrame> ParseArmRequest(const Frame& frame);
[[nodiscard]] std::variant<HandRequest, BadFrame> ParseHandRequest(const Frame& frame);

/// The command a request is sent as.
[[nodiscard]] ArmCommand CommandOf(const ArmRequest& request) noexcept;

/// The whole frame. A Move with kOther or kIdle gets a number that no mode has.
[[nodiscard]] std::vector<std::byte> EncodeRequest(std::uint32_t command_id,
                                                   const ArmRequest& request);
[[nodiscard]] std::vector<std::byte> EncodeRequest(std::uint32_t command_id,
                                                   const HandRequest& request);

/// An answer to the arm's client with nothing but a status. @param command  that is answered.
[[nodiscard]] std::vector<std::byte> EncodeArmAnswer(ArmCommand command, std::uint32_t command_id,
                                                     std::uint8_t status);
/// Connect's. @param version  the server's.
[[nodiscard]] std::vector<std::byte> EncodeArmConnectAnswer(std::uint32_t command_id,
                                                            ConnectStatus status,
                                                            std::uint16_t version);
[[nodiscard]] std::vector<std::byte> EncodeCartesianLimitAnswer(std::uint32_t command_id,
                                                                SetterStatus status,
                                                                const CartesianLimit& limit);
/// LoadModelLibrary's. @param library  its bytes; empty unless success.
[[nodiscard]] std::vector<std::byte> EncodeModelLibraryAnswer(std::uint32_t command_id,
                                                              ModelLibraryStatus status,
                                                              std::span<const std::byte> library);
[[nodiscard]] std::vector<std::byte> EncodeHandAnswer(HandCommandId command,
                                                      std::uint32_t command_id, HandResult result);
[[nodiscard]] std::vector<std::byte> EncodeHandConnectAnswer(std::uint32_t command_id,
                                                             ConnectStatus status,
                                                             std::uint16_t version);

/// What the arm answered: the status, and what follows it.
struct ArmAnswer {
  std::uint8_t status = 0;
  std::uint16_t version = 0;           ///< Connect
  CartesianLimit limit;                ///< GetCartesianLimit
  std::span<const std::byte> library;  ///< LoadModelLibrary; of the frame's payload
};
/// What the hand answered.
struct HandAnswer {
  HandResult result = HandResult::kFail;  ///< Connect: kSuccess, or kFail for another version
  std::uint16_t version = 0;              ///< Connect
};
/// Reads an answer as libfranka does: the frame's command counts for nothing, its command_id tells
/// what is answered; bytes beyond those needed are left alone. A status that does not exist is a
/// BadFrame of the hand's; of the arm's it is the caller's to judge.
/// @param asked  the request that has the frame's command_id.
[[nodiscard]] std::variant<ArmAnswer, BadFrame> ParseArmAnswer(ArmCommand asked,
                                                               const Frame& frame);
[[nodiscard]] std::variant<HandAnswer, BadFrame> ParseHandAnswer(HandCommandId asked,
                                                                 const Frame& frame);

}  // namespace twin::fci
