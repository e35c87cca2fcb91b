#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

void ReadNoise(const YamlNode& node, PlantSection& plant) {
  const YamlMap map = node.Map({"q", "dq", "tau_J"});
  IfGiven(map, "q",
          [&](const YamlNode& n) { plant.noise_q = n.Quantity(Dimension::kAngle, 0, 1); });
  IfGiven(map, "dq", [&](const YamlNode& n) {
    plant.noise_dq = n.Quantity(Dimension::kAngularVelocity, 0, 10);
  });
  IfGiven(map, "tau_J",
          [&](const YamlNode& n) { plant.noise_tau_J = n.Quantity(Dimension::kTorque, 0, 100); });
}

void ReadTilt(const YamlNode& node, plant::BaseTilt& tilt) {
  const YamlMap map = node.Map({"roll", "pitch"});
  IfGiven(map, "roll",
          [&](const YamlNode& n) { tilt.roll = n.Quantity(Dimension::kAngle, -0.2, 0.2); });
  IfGiven(map, "pitch",
          [&](const YamlNode& n) { tilt.pitch = n.Quantity(Dimension::kAngle, -0.2, 0.2); });
}

/// What panels offer, by the names they have.
std::array<Spelling<PanelAction>, kPanelActions> PanelActionNames() {
  std::array<Spelling<PanelAction>, kPanelActions> names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto action = static_cast<PanelAction>(i);
    names[i] = {Name(action), action};
  }
  return names;
}

}  // namespace

double ReadDrift(const YamlNode& node) {
  return node.Quantity(Dimension::kDrift, -1000, 1000);
}

std::string ReadName(const YamlNode& node, Place& place) {
  place = {node.Text(), node.Where()};
  return place.name;
}

void ReadRobot(const YamlNode& node, Scenario& scenario) {
  RobotSection& robot = scenario.robot;
  const YamlMap map = node.Map({"model", "hand", "q_start", "clock_drift", "load"});
  IfGiven(map, "model",
          [&](const YamlNode& n) { robot.model = ReadName(n, scenario.places.robot); });
  IfGiven(map, "hand", [&](const YamlNode& n) { robot.hand = ReadChoice(n, kHandNames); });
  IfGiven(map, "q_start",
          [&](const YamlNode& n) { robot.q_start = n.JointQuantity(Dimension::kAngle); });
  IfGiven(map, "clock_drift", [&](const YamlNode& n) { robot.clock_drift_ppm = ReadDrift(n); });
  IfGiven(map, "load", [&](const YamlNode& n) { robot.load = ReadLoad(n); });
}

void ReadPlant(const YamlNode& node, PlantSection& plant) {
  const YamlMap map =
      node.Map({"kind", "friction", "armature", "elasticity", "mass_scale", "base_tilt", "noise"});
  IfGiven(map, "kind", [&](const YamlNode& n) { plant.kind = ReadChoice(n, kPlantNames); });
  IfGiven(map, "friction",
          [&](const YamlNode& n) { plant.friction = ReadChoice(n, kFrictionNames); });
  IfGiven(map, "armature", [&](const YamlNode& n) { plant.armature = n.Bool(); });
  IfGiven(map, "elasticity",
          [&](const YamlNode& n) { plant.elasticity = ReadChoice(n, kElasticityNames); });
  IfGiven(map, "mass_scale", [&](const YamlNode& n) { plant.mass_scale = n.Number(0.5, 2); });
  IfGiven(map, "base_tilt", [&](const YamlNode& n) { ReadTilt(n, plant.base_tilt); });
  IfGiven(map, "noise", [&](const YamlNode& n) { ReadNoise(n, plant); });
}

std::vector<robot::PanelEvent> ReadPanel(const YamlNode& node) {
  const auto names = PanelActionNames();
  std::vector<robot::PanelEvent> panel;
  for (const YamlNode& item : node.Items()) {
    const YamlMap map = item.Map({"at", "action"});
    const YamlNode at = map.Require("at");
    robot::PanelEvent event;
    event.at = at.Time(Duration::zero(), kDay);
    event.action = ReadChoice(map.Require("action"), names);
    if (!panel.empty() && event.at < panel.back().at) {
      at.Fail("comes before the event above it; give them in order of time");
    }
    panel.push_back(event);
  }
  return panel;
}

}  // namespace twin::scenario
