#include "twin/scenario/operator.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/scenario/link_section.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

void OperatorSection::Validate() const {
  if (device.empty()) throw InputError("operator.device: names no device; give one");
  (void)MakeTeleoperator(*this);
  const teleop::WireConfig wire = MakeWire(*this);
  wire.to_robot.Validate("operator.to_robot");
  wire.from_robot.Validate("operator.from_robot");
}

teleop::TeleoperatorConfig MakeTeleoperator(const OperatorSection& section) {
  control::ParameterReader reader(section.settings, "operator.settings");
  const teleop::TeleoperatorConfig config = teleop::ReadTeleoperatorConfig(reader);
  reader.RefuseUnread();
  return config;
}

teleop::WireConfig MakeWire(const OperatorSection& section) {
  return {.to_robot = MakeDirection(section.to_robot),
          .from_robot = MakeDirection(section.from_robot)};
}

}  // namespace twin::scenario
