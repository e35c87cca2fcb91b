#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "scenario/names.h"
#include "scenario/trajectory_reader.h"
#include "scenario/yaml_node.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
namespace {

constexpr Duration kLongestDelay = std::chrono::seconds(10);

/// Calls `use` with the value of a key that may be absent.
template <typename Use>
void IfGiven(const YamlMap& map, std::string_view key, Use use) {
  if (const auto node = map.Find(key)) use(*node);
}

template <typename Enum, std::size_t N>
Enum ReadChoice(const YamlNode& node, const std::array<Spelling<Enum>, N>& names) {
  return node.Choice(std::span<const Spelling<Enum>>(names));
}

/// "80 us", {constant: 80 us} or {log_normal: {median: 80 us, sigma: 0.3, offset: 20 us}}.
Delay ReadDelay(const YamlNode& node) {
  Delay delay;
  if (node.IsScalar()) {
    delay.constant = node.Time(Duration::zero(), kLongestDelay);
    return delay;
  }
  const YamlMap map = node.Map({"constant", "log_normal"});
  const auto constant = map.Find("constant");
  const auto log_normal = map.Find("log_normal");
  if (constant.has_value() == log_normal.has_value()) {
    node.Fail("give exactly one of constant and log_normal");
  }
  if (constant) {
    delay.constant = constant->Time(Duration::zero(), kLongestDelay);
    return delay;
  }
  const YamlMap shape = log_normal->Map({"median", "sigma", "offset"});
  delay.kind = Delay::Kind::kLogNormal;
  delay.median = shape.Require("median").Time(Duration(1), kLongestDelay);
  delay.sigma = shape.Require("sigma").Number(0, 5);
  IfGiven(shape, "offset",
          [&](const YamlNode& n) { delay.offset = n.Time(Duration::zero(), kLongestDelay); });
  return delay;
}

void ReadRobot(const YamlNode& node, RobotSection& robot) {
  const YamlMap map = node.Map({"model", "hand", "q_start"});
  IfGiven(map, "model", [&](const YamlNode& n) { robot.model = n.Text(); });
  IfGiven(map, "hand", [&](const YamlNode& n) { robot.hand = ReadChoice(n, kHandNames); });
  IfGiven(map, "q_start",
          [&](const YamlNode& n) { robot.q_start = n.JointQuantity(Dimension::kAngle); });
}

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

void ReadPlant(const YamlNode& node, PlantSection& plant) {
  const YamlMap map = node.Map({"kind", "friction", "armature", "noise"});
  IfGiven(map, "kind", [&](const YamlNode& n) { plant.kind = ReadChoice(n, kPlantNames); });
  IfGiven(map, "friction",
          [&](const YamlNode& n) { plant.friction = ReadChoice(n, kFrictionNames); });
  IfGiven(map, "armature", [&](const YamlNode& n) { plant.armature = n.Bool(); });
  IfGiven(map, "noise", [&](const YamlNode& n) { ReadNoise(n, plant); });
}

void ReadLink(const YamlNode& node, LinkSection& link) {
  const YamlMap map =
      node.Map({"state_delay", "command_delay", "state_loss", "command_loss", "d_INT"});
  IfGiven(map, "state_delay", [&](const YamlNode& n) { link.state_delay = ReadDelay(n); });
  IfGiven(map, "command_delay", [&](const YamlNode& n) { link.command_delay = ReadDelay(n); });
  IfGiven(map, "state_loss", [&](const YamlNode& n) {
    link.state_loss_percent = n.Quantity(Dimension::kPercent, 0, 100);
  });
  IfGiven(map, "command_loss", [&](const YamlNode& n) {
    link.command_loss_percent = n.Quantity(Dimension::kPercent, 0, 100);
  });
  IfGiven(map, "d_INT",
          [&](const YamlNode& n) { link.d_INT = n.Time(Duration::zero(), kCycle - Duration(1)); });
}

void ReadOnboard(const YamlNode& node, OnboardSection& onboard) {
  const YamlMap map = node.Map({"K_theta", "damping_ratio", "abort_after_lost"});
  IfGiven(map, "K_theta", [&](const YamlNode& n) {
    onboard.K_theta = n.JointQuantity(Dimension::kStiffness);
    for (const double K : onboard.K_theta) {
      if (K >= 0 && K <= onboard::kMaxJointStiffness) continue;
      n.Fail(fmt::format("{} Nm/rad is out of range; each must lie in [0, {}] Nm/rad", K,
                         onboard::kMaxJointStiffness));
    }
  });
  IfGiven(map, "damping_ratio",
          [&](const YamlNode& n) { onboard.damping_ratio = n.Number(1e-3, 2); });
  IfGiven(map, "abort_after_lost", [&](const YamlNode& n) {
    onboard.abort_after_lost = static_cast<std::uint32_t>(n.Integer(1, 1'000'000));
  });
}

void ReadTick(const YamlNode& node, TickSection& tick) {
  const YamlMap map =
      node.Map({"generator", "lambda", "rate_matching", "finish_tolerance", "cost"});
  IfGiven(map, "generator",
          [&](const YamlNode& n) { tick.generator = ReadChoice(n, kGeneratorNames); });
  IfGiven(map, "lambda", [&](const YamlNode& n) { tick.lambda = n.Number(1e-9, 1); });
  IfGiven(map, "rate_matching", [&](const YamlNode& n) { tick.rate_matching = n.Bool(); });
  IfGiven(map, "finish_tolerance", [&](const YamlNode& n) {
    tick.finish_tolerance = n.Quantity(Dimension::kAngle, 1e-9, 1e-2);
  });
  IfGiven(map, "cost", [&](const YamlNode& n) { tick.cost = ReadDelay(n); });
}

void ReadController(const YamlNode& node, ControllerSection& controller) {
  const YamlMap map =
      node.Map({"type", "rate", "clock_drift", "phase", "wake_delay", "cost", "feed_forward"});
  IfGiven(map, "type", [&](const YamlNode& n) { controller.type = n.Text(); });
  IfGiven(map, "rate", [&](const YamlNode& n) {
    controller.rate_hz = n.Quantity(Dimension::kFrequency, 1, 1000);
  });
  IfGiven(map, "clock_drift", [&](const YamlNode& n) {
    controller.clock_drift_ppm = n.Quantity(Dimension::kDrift, -1000, 1000);
  });
  IfGiven(map, "phase",
          [&](const YamlNode& n) { controller.phase = n.Time(Duration::zero(), kLongestDelay); });
  IfGiven(map, "wake_delay", [&](const YamlNode& n) { controller.wake_delay = ReadDelay(n); });
  IfGiven(map, "cost", [&](const YamlNode& n) { controller.cost = ReadDelay(n); });
  IfGiven(map, "feed_forward",
          [&](const YamlNode& n) { controller.feed_forward = ReadChoice(n, kFeedForwardNames); });
}

void ReadMotion(const YamlNode& node, const std::filesystem::path& folder, MotionSection& motion) {
  const YamlMap map = node.Map({"interface", "trajectory"});
  IfGiven(map, "interface",
          [&](const YamlNode& n) { motion.interface = ReadChoice(n, kInterfaceNames); });
  ReadTrajectory(map.Require("trajectory"), folder, motion);
}

/// The name of one of the scene's cameras, or a free camera that orbits a point.
void ReadCamera(const YamlNode& node, RenderSection& render) {
  constexpr double kTurn = 2 * std::numbers::pi;
  if (node.IsScalar()) {
    render.camera = node.Text();
    return;
  }
  const YamlMap map = node.Map({"azimuth", "elevation", "distance", "lookat"});
  IfGiven(map, "azimuth", [&](const YamlNode& n) {
    render.azimuth = n.Quantity(Dimension::kAngle, -kTurn, kTurn);
  });
  IfGiven(map, "elevation", [&](const YamlNode& n) {
    render.elevation = n.Quantity(Dimension::kAngle, -kTurn / 4, kTurn / 4);
  });
  IfGiven(map, "distance",
          [&](const YamlNode& n) { render.distance = n.Quantity(Dimension::kLength, 0.01, 1000); });
  IfGiven(map, "lookat", [&](const YamlNode& n) {
    const std::vector<YamlNode> items = n.Items();
    if (items.size() != render.lookat.size()) n.Fail("needs 3 lengths: x, y, z");
    for (std::size_t i = 0; i < items.size(); ++i) {
      render.lookat[i] = items[i].Quantity(Dimension::kLength, -1000, 1000);
    }
  });
}

void ReadRender(const YamlNode& node, RenderSection& render) {
  const YamlMap map = node.Map({"enabled", "width", "height", "fps", "camera"});
  const auto integer = [](const YamlNode& n, std::uint64_t least, std::uint64_t most) {
    return static_cast<int>(n.Integer(least, most));
  };
  IfGiven(map, "enabled", [&](const YamlNode& n) { render.enabled = n.Bool(); });
  IfGiven(map, "width", [&](const YamlNode& n) { render.width = integer(n, 16, 4096); });
  IfGiven(map, "height", [&](const YamlNode& n) { render.height = integer(n, 16, 4096); });
  IfGiven(map, "fps", [&](const YamlNode& n) {
    render.fps = static_cast<int>(n.Quantity(Dimension::kFrequency, 1, 240));
    if (n.Quantity(Dimension::kFrequency, 1, 240) != render.fps) n.Fail("must be whole Hz");
  });
  IfGiven(map, "camera", [&](const YamlNode& n) { ReadCamera(n, render); });
}

Drive ReadDrive(const YamlNode& node) {
  try {
    return DriveFromName(node.Text());
  } catch (const InputError& error) {
    node.Fail(error.what());
  }
}

Scenario ReadScenario(const YamlNode& root, const std::filesystem::path& folder) {
  Scenario scenario;
  const YamlMap map =
      root.Map({"name", "description", "seed", "backend", "drive", "scene", "robot", "plant",
                "link", "int", "tick", "controller", "motion", "render", "record"});
  scenario.name = map.Require("name").Text();
  IfGiven(map, "description", [&](const YamlNode& n) { scenario.description = n.Text(); });
  IfGiven(map, "seed", [&](const YamlNode& n) {
    scenario.seed = n.Integer(0, std::numeric_limits<std::uint64_t>::max());
  });
  IfGiven(map, "backend", [&](const YamlNode& n) { scenario.backend = n.Text(); });
  IfGiven(map, "drive", [&](const YamlNode& n) { scenario.drive = ReadDrive(n); });
  IfGiven(map, "scene", [&](const YamlNode& n) { scenario.scene = n.Text(); });
  IfGiven(map, "robot", [&](const YamlNode& n) { ReadRobot(n, scenario.robot); });
  IfGiven(map, "plant", [&](const YamlNode& n) { ReadPlant(n, scenario.plant); });
  IfGiven(map, "link", [&](const YamlNode& n) { ReadLink(n, scenario.link); });
  IfGiven(map, "int", [&](const YamlNode& n) { ReadOnboard(n, scenario.onboard); });
  ReadMotion(map.Require("motion"), folder, scenario.motion);
  if (scenario.motion.interface == control::CommandInterface::kJointVelocity) {
    scenario.tick.generator = loop::Generator::kNone;
  }
  IfGiven(map, "tick", [&](const YamlNode& n) { ReadTick(n, scenario.tick); });
  IfGiven(map, "controller", [&](const YamlNode& n) { ReadController(n, scenario.controller); });
  IfGiven(map, "render", [&](const YamlNode& n) { ReadRender(n, scenario.render); });
  IfGiven(map, "record", [&](const YamlNode& n) { scenario.record = n.Bool(); });
  try {
    scenario.Validate();
  } catch (const InputError& error) {
    root.Fail(error.what());
  }
  return scenario;
}

}  // namespace

Scenario Load(const std::filesystem::path& path) {
  return ReadScenario(YamlNode::ParseFile(path.string()), path.parent_path());
}

Scenario Parse(const std::string& text, const std::filesystem::path& file) {
  return ReadScenario(YamlNode::Parse(text, file.string()), file.parent_path());
}

}  // namespace twin::scenario
