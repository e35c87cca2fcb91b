#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "twin/core/hand_command.h"
#include "twin/core/robot_state.h"
#include "twin/fci/protocol.h"
#include "twin/fci/requests.h"
#include "twin/record/packet.h"

namespace twin::fci {

/// Format of a transcript.
struct TranscriptOptions {
  bool fields = true;  ///< true: every field of every message; false: one line per message
  std::uint16_t arm_port = kArmPort;
  std::uint16_t hand_port = kHandPort;
  std::uint16_t vacuum_port = kVacuumPort;
};

/// Prints a capture for users, message by message: states, commands, requests and answers of
/// arm, hand and vacuum gripper. It reassembles TCP streams from their packets and labels an answer
/// with its request. Data outside the protocol is printed as such.
///
///     12.345678901 s  127.0.0.1:40000 > 127.0.0.1:1337  request 7: Move
///         modes = joint_impedance joint_position
///
/// Its memory is bounded for any input.
///
/// Threads: one. Errors: none; a malformed message prints a line that names the fault.
class Transcript {
 public:
  explicit Transcript(const TranscriptOptions& options);
  ~Transcript();

  /// @returns the lines that this packet completes, each with a newline; may be empty.
  [[nodiscard]] std::string Take(const record::Packet& packet);

  /// TCP packets so far on ports other than those of the options.
  [[nodiscard]] std::uint64_t elsewhere() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Messages as text, one line per field: "    q = 0 -0.785 ...\n". Numbers read back to the same
// bits.

// @param protocol  whose fields are printed.

[[nodiscard]] std::string FieldsOf(const RobotState& state, Protocol protocol = Protocol::k5);
[[nodiscard]] std::string FieldsOf(const RobotCommand& command);
[[nodiscard]] std::string FieldsOf(const HandState& state);
[[nodiscard]] std::string FieldsOf(const VacuumState& state);
[[nodiscard]] std::string FieldsOf(const ArmRequest& request, Protocol protocol = Protocol::k5);
[[nodiscard]] std::string FieldsOf(const HandRequest& request);
/// The fields of an answer to `asked`, its status in words.
[[nodiscard]] std::string FieldsOf(ArmCommand asked, const ArmAnswer& answer);
[[nodiscard]] std::string FieldsOf(HandCommandId asked, const HandAnswer& answer);
[[nodiscard]] std::string FieldsOf(VacuumCommandId asked, const HandAnswer& answer);

}  // namespace twin::fci
