#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "scenario/link_reader.h"
#include "scenario/max_deviation.h"
#include "scenario/parameter_tree.h"
#include "scenario/section_readers.h"
#include "scenario/trajectory_reader.h"
#include "scenario/yaml_node.h"
#include "twin/core/error.h"
#include "twin/scenario/names.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
namespace {

loop::Generator ReadGenerator(const YamlNode& node, control::CommandInterface interface) {
  const loop::Generator generator = ReadChoice(node, kGeneratorNames);
  if (const std::string_view misfit = loop::Misfit(generator, interface); !misfit.empty()) {
    node.Fail(fmt::format("{}, and motion.interface is {}; say none, or leave it out", misfit,
                          NameOf(kInterfaceNames, interface)));
  }
  return generator;
}

/// What the other sections imply for what this one does not say.
TickSection TickDefaults(const Scenario& scenario) {
  TickSection tick;
  if (scenario.motion.interface == control::CommandInterface::kTorque) tick = TorqueTick();
  if (scenario.loop != loop::LoopKind::kAsynchronous) tick.period_tolerance = Duration::zero();
  return tick;
}

/// "off", or the losses in a row it bridges.
std::optional<int> ReadViability(const YamlNode& node, control::CommandInterface interface) {
  if (node.IsScalar() && node.Text() == "off") return {};
  if (interface == control::CommandInterface::kTorque) {
    node.Fail(
        "keeps the limits of commanded motions, and motion.interface is torque; say off, or leave "
        "it out");
  }
  return static_cast<int>(node.Integer(0, reference::ViableAxis::kMostLost));
}

void ReadTick(const YamlNode& node, Scenario& scenario) {
  TickSection& tick = scenario.tick;
  const YamlMap map =
      node.Map({"generator", "lambda", "rate_matching", "finish_tolerance", "period_tolerance",
                "stall_time", "low_pass", "limiter", "viability", "cost"});
  IfGiven(map, "generator",
          [&](const YamlNode& n) { tick.generator = ReadGenerator(n, scenario.motion.interface); });
  IfGiven(map, "lambda", [&](const YamlNode& n) { tick.lambda = n.Number(1e-9, 1); });
  IfGiven(map, "rate_matching", [&](const YamlNode& n) { tick.rate_matching = n.Bool(); });
  IfGiven(map, "finish_tolerance", [&](const YamlNode& n) {
    tick.finish_tolerance = n.Quantity(Dimension::kAngle, 1e-9, 1e-2);
  });
  IfGiven(map, "period_tolerance", [&](const YamlNode& n) {
    if (scenario.loop != loop::LoopKind::kAsynchronous) {
      n.Fail("only the asynchronous loop has one; leave it out, or say loop: asynchronous");
    }
    tick.period_tolerance = n.Time(Duration::zero(), kCycle);
  });
  IfGiven(map, "stall_time", [&](const YamlNode& n) {
    tick.stall_time = n.Time(std::chrono::milliseconds(1), std::chrono::seconds(10));
  });
  IfGiven(map, "low_pass", [&](const YamlNode& n) { tick.low_pass_hz = ReadCutoff(n); });
  IfGiven(map, "limiter", [&](const YamlNode& n) { tick.limiter = n.Bool(); });
  if (tick.generator != loop::Generator::kRejoining) tick.viability.reset();
  IfGiven(map, "viability",
          [&](const YamlNode& n) { tick.viability = ReadViability(n, scenario.motion.interface); });
  IfGiven(map, "cost", [&](const YamlNode& n) { tick.cost = ReadDelay(n); });
}

/// A path is against the scenario's folder.
std::filesystem::path ReadLibrary(const YamlNode& node, const std::filesystem::path& folder) {
  if (node.Text().empty()) node.Fail("names no file; leave it out, or give a library's path");
  return std::filesystem::absolute(folder / node.Text()).lexically_normal();
}

/// An application says itself which controllers it uses, and what they are told.
void RefuseControllerOf(const YamlNode& node) {
  for (const auto& [key, value] : node.Entries()) {
    if (key != "library" && key != "type" && key != "parameters" && key != "target_noise") continue;
    value.Fail("beside an application, which chooses its controllers itself; leave it out");
  }
}

void ReadController(const YamlNode& node, const std::filesystem::path& folder, Scenario& scenario) {
  ControllerSection& controller = scenario.controller;
  if (scenario.application) RefuseControllerOf(node);
  const YamlMap map = node.Map({"library", "type", "parameters", "rate", "clock_drift", "phase",
                                "wake_delay", "cost", "feed_forward", "target_noise"});
  IfGiven(map, "type",
          [&](const YamlNode& n) { controller.type = ReadName(n, scenario.places.controller); });
  IfGiven(map, "library", [&](const YamlNode& n) {
    (void)map.Require("type");
    controller.library = ReadLibrary(n, folder);
    scenario.places.library = {controller.library.string(), n.Where()};
  });
  IfGiven(map, "parameters", [&](const YamlNode& n) {
    controller.parameters = ReadParameters(n);
    (void)map.Require("type");  // whose parameters they are
  });
  IfGiven(map, "rate", [&](const YamlNode& n) {
    controller.rate_hz = n.Quantity(Dimension::kFrequency, 1, 1000);
  });
  IfGiven(map, "clock_drift",
          [&](const YamlNode& n) { controller.clock_drift_ppm = ReadDrift(n); });
  IfGiven(map, "phase",
          [&](const YamlNode& n) { controller.phase = n.Time(Duration::zero(), kLongestDelay); });
  IfGiven(map, "wake_delay", [&](const YamlNode& n) { controller.wake_delay = ReadDelay(n); });
  IfGiven(map, "cost", [&](const YamlNode& n) { controller.cost = ReadDelay(n); });
  IfGiven(map, "feed_forward",
          [&](const YamlNode& n) { controller.feed_forward = ReadChoice(n, kFeedForwardNames); });
  IfGiven(map, "target_noise", [&](const YamlNode& n) {
    controller.target_noise = n.Quantity(DimensionOf(scenario.motion.interface), 0, 1);
  });
}

void ReadMotion(const YamlNode& node, const std::filesystem::path& folder, MotionSection& motion) {
  const YamlMap map = node.Map({"interface", "controller", "trajectory", "poses", "plan"});
  IfGiven(map, "interface",
          [&](const YamlNode& n) { motion.interface = ReadChoice(n, kInterfaceNames); });
  IfGiven(map, "controller", [&](const YamlNode& n) {
    motion.controller = ReadChoice(n, kControllerNames);
    if (motion.interface == control::CommandInterface::kTorque) {
      n.Fail("on the torque interface the commanded torque takes its place; leave it out");
    }
  });
  const auto poses = map.Find("poses");
  const auto plan = map.Find("plan");
  for (const auto& either : {poses, plan}) {
    if (either && map.Find("trajectory")) {
      either->Fail("beside motion.trajectory; a motion has one of the two");
    }
  }
  if (plan && poses) plan->Fail("beside motion.poses; a motion has one of the two");
  if (plan) {
    ReadPlan(*plan, motion);
  } else if (poses) {
    ReadPoses(*poses, motion);
  } else {
    ReadTrajectory(map.Require("trajectory"), folder, motion);
  }
}

void ReadApplication(const YamlNode& node, Scenario& scenario) {
  const YamlMap map = node.Map({"type", "parameters"});
  ApplicationSection& application = scenario.application.emplace();
  application.type = ReadName(map.Require("type"), scenario.places.application);
  IfGiven(map, "parameters",
          [&](const YamlNode& n) { application.parameters = ReadParameters(n); });
}

/// One motion, or an application that makes its own.
void ReadMotionOrApplication(const YamlMap& map, const std::filesystem::path& folder,
                             Scenario& scenario) {
  if (const auto application = map.Find("application")) {
    if (const auto motion = map.Find("motion")) {
      motion->Fail("beside an application, which makes its motions itself; leave one of them out");
    }
    ReadApplication(*application, scenario);
    return;
  }
  ReadMotion(map.Require("motion"), folder, scenario.motion);
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
  scenario.places.folder = folder;
  if (root.Has("int")) {
    for (const auto& [key, value] : root.Entries()) {
      if (key == "int") value.Fail("this section is called onboard now; rename it");
    }
  }
  const YamlMap map = root.Map(
      {"name",       "description", "seed",        "backend",       "drive",   "loop",
       "scene",      "robot",       "plant",       "link",          "onboard", "tick",
       "controller", "motion",      "application", "perturbations", "panel",   "hand",
       "render",     "record",      "objects",     "operator",      "base",    "max_deviation"});
  scenario.name = map.Require("name").Text();
  IfGiven(map, "description", [&](const YamlNode& n) { scenario.description = n.Text(); });
  IfGiven(map, "seed", [&](const YamlNode& n) {
    scenario.seed = n.Integer(0, std::numeric_limits<std::uint64_t>::max());
  });
  IfGiven(map, "backend",
          [&](const YamlNode& n) { scenario.backend = ReadName(n, scenario.places.backend); });
  if (scenario.backend == kRemoteBackend) scenario.drive = Drive::kRemote;
  IfGiven(map, "drive", [&](const YamlNode& n) { scenario.drive = ReadDrive(n); });
  IfGiven(map, "loop", [&](const YamlNode& n) { scenario.loop = ReadChoice(n, kLoopNames); });
  IfGiven(map, "scene",
          [&](const YamlNode& n) { scenario.scene = ReadName(n, scenario.places.scene); });
  IfGiven(map, "objects", [&](const YamlNode& n) { scenario.objects = ReadObjects(n); });
  IfGiven(map, "robot", [&](const YamlNode& n) { ReadRobot(n, scenario); });
  IfGiven(map, "base", [&](const YamlNode& n) { ReadBase(n, scenario); });
  IfGiven(map, "plant", [&](const YamlNode& n) { ReadPlant(n, scenario.plant); });
  IfGiven(map, "link", [&](const YamlNode& n) { ReadLink(n, scenario.link); });
  IfGiven(map, "onboard", [&](const YamlNode& n) { ReadOnboard(n, scenario.onboard); });
  ReadMotionOrApplication(map, folder, scenario);
  IfGiven(map, "max_deviation",
          [&](const YamlNode& n) { scenario.max_deviation = ReadMaxDeviation(n, scenario); });
  IfGiven(map, "operator", [&](const YamlNode& n) { ReadOperator(n, scenario); });
  scenario.tick = TickDefaults(scenario);
  if (scenario.motion.interface == control::CommandInterface::kTorque) {
    scenario.controller.type = "joint_trajectory_effort";
  }
  IfGiven(map, "tick", [&](const YamlNode& n) { ReadTick(n, scenario); });
  IfGiven(map, "controller", [&](const YamlNode& n) { ReadController(n, folder, scenario); });
  IfGiven(map, "perturbations",
          [&](const YamlNode& n) { scenario.perturbations = ReadPerturbations(n); });
  IfGiven(map, "panel", [&](const YamlNode& n) { scenario.panel = ReadPanel(n); });
  IfGiven(map, "hand", [&](const YamlNode& n) { scenario.hand = ReadHand(n); });
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
