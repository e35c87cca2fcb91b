#include "scenario/link_reader.h"
#include "scenario/parameter_tree.h"
#include "scenario/section_readers.h"
#include "scenario/yaml_node.h"
#include "twin/control/parameters.h"
#include "twin/core/error.h"
#include "twin/scenario/link.h"
#include "twin/scenario/operator.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

void ReadOperator(const YamlNode& node, Scenario& scenario) {
  const YamlMap map =
      node.Map({"device", "parameters", "settings", "to_robot_delay", "to_robot_loss",
                "to_robot_duplication", "to_robot_reordering", "from_robot_delay",
                "from_robot_loss", "from_robot_duplication", "from_robot_reordering"});
  OperatorSection& section = scenario.operator_section.emplace();
  section.device = ReadName(map.Require("device"), scenario.places.device);
  IfGiven(map, "parameters", [&](const YamlNode& n) { section.parameters = ReadParameters(n); });
  IfGiven(map, "settings", [&](const YamlNode& n) { section.settings = ReadParameters(n); });
  ReadDirection(map, "to_robot", section.to_robot);
  ReadDirection(map, "from_robot", section.from_robot);
}

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
