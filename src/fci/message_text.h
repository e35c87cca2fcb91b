#pragma once

#include <string>

#include "twin/core/hand_command.h"
#include "twin/core/robot_command.h"
#include "twin/core/robot_state.h"
#include "twin/fci/requests.h"

// Messages as text, one line per field: "    q = 0 -0.785 ...\n". Numbers read back to the same
// bits.
namespace twin::fci {

[[nodiscard]] std::string FieldsOf(const RobotState& state);
[[nodiscard]] std::string FieldsOf(const RobotCommand& command);
[[nodiscard]] std::string FieldsOf(const HandState& state);
[[nodiscard]] std::string FieldsOf(const ArmRequest& request);
[[nodiscard]] std::string FieldsOf(const HandRequest& request);
/// The fields of an answer to `asked`, its status in words.
[[nodiscard]] std::string FieldsOf(ArmCommand asked, const ArmAnswer& answer);
[[nodiscard]] std::string FieldsOf(HandCommandId asked, const HandAnswer& answer);

}  // namespace twin::fci
