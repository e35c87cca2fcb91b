#include "scenario/sections.h"

namespace twin::scenario {

static void Describe(Map& map, ApplicationSection& application, Place& place) {
  map.Require("type", Identifier(application.type), "Name in the registry of applications.")
      .At(place);
  map.Add("parameters", Parameters(application.parameters), "Parameters of the application.")
      .OmitIf(application.parameters.empty());
}

namespace {

/// A section that may be absent and that remembers the place of a name.
template <typename T>
Value OptionalSection(std::optional<T>& section, Place& place) {
  return Optional(section, [&place](T& one) {
    return Section([&place, &one](Map& map) { Describe(map, one, place); }, Style::kBlock);
  });
}

/// Sets the defaults of tick and controller that depend on loop and motion.
void SetDefaults(Scenario& scenario) {
  const bool is_torque = scenario.motion.interface == control::CommandInterface::kTorque;
  scenario.tick = is_torque ? TorqueTick() : TickSection{};
  if (scenario.loop != loop::LoopKind::kAsynchronous) {
    scenario.tick.period_tolerance = Duration::zero();
  }
  if (is_torque) scenario.controller.type = "joint_trajectory_effort";
}

/// Absolute for a file beside the scenario; others are sought in the models folder by each run.
std::filesystem::path Scene(const std::string& text, const Scenario& s) {
  std::error_code none;
  const std::filesystem::path beside = s.places.folder / text;
  const bool is_beside = !text.empty() && std::filesystem::is_regular_file(beside, none);
  return is_beside ? std::filesystem::absolute(beside).lexically_normal()
                   : std::filesystem::path(text);
}

void AddWhatIsRun(Map& map, Scenario& s) {
  map.Require("name", Identifier(s.name), "Names the folder of results.");
  map.Add("description", Text(s.description), "Description for people.");
  map.Add("seed", Seed(s.seed), "Seed of every random number of the run.");
  map.Add("backend", Identifier(s.backend),
          "What stands for the robot: mujoco, or fci for one at the other end of a wire.")
      .At(s.places.backend);
  Value drive = Choice(s.drive, kDriveNames);
  drive.read = [&s](const YamlNode& node) {
    s.drive = node.Checked([name = node.Text()] { return DriveFromName(name); });
  };
  map.Add("drive", drive, "The virtual clock, or the wall clock; leave it out with backend fci.")
      .OmitIf(s.is_remote())
      .Then([&s](const YamlNode& node) {
        if (!s.is_remote()) return;
        node.Fail("the robot of backend fci keeps its own time; leave drive out");
      });
  map.Add("loop", Choice(s.loop, kLoopNames),
          "The workstation's: a thread for communication beside the controller; one periodic loop "
          "of both; or one that the robot paces.");
  map.Add("scene",
          Converted(s.scene.string(), Text, [&s](auto& text) { s.scene = Scene(text, s); }),
          "MJCF of the world: beside this file, in the models folder, or absolute; empty: "
          "scenes/floor.xml.")
      .At(s.places.scene);
}

void AddWhatIsThere(Map& map, Scenario& s) {
  map.Add("objects", ListOf(s.objects), "Bodies beside what the scene holds.")
      .OmitIf(s.objects.empty());
  map.Add("robot", Section([&s](Map& of) { DescribeRobot(of, s); }, Style::kBlock), "The arm.");
  map.Add("base", OptionalSection(s.base, s.places.base),
          "Mobile base; absent: the arm stands on the world.");
  map.Add("plant", SectionOf(s.plant, Style::kBlock), "The robot's body.");
  map.Add("link", SectionOf(s.link, Style::kBlock),
          "state: robot to workstation; command: workstation to robot.");
  map.Add("onboard", SectionOf(s.onboard, Style::kBlock), "The robot's own controller.");
  map.Renamed("int", "this section is called onboard now; rename it");
}

void AddWhatMoves(Map& map, Scenario& s) {
  map.Add("tick", Section([&s](Map& of) { DescribeTick(of, s); }, Style::kBlock),
          "The workstation's 1 kHz step.");
  map.Add("controller", Section([&s](Map& of) { DescribeController(of, s); }, Style::kBlock),
          "The workstation's controller.");
  const auto set_defaults = [&s](const YamlNode& /*node*/) { SetDefaults(s); };
  map.Add("application", OptionalSection(s.application, s.places.application),
          "Task in place of one motion, see ../applications.")
      .Then(set_defaults);
  map.Add("motion", Section([&s](Map& of) { DescribeMotion(of, s); }, Style::kBlock),
          "Motion of the arm.")
      .OmitIf(s.application.has_value())
      .Then(set_defaults);
  map.Add("limits", LimitsOf(s.limits), "Limits that the lab demands beside the robot's own.")
      .OmitIf(s.limits.empty());
  map.Add("max_deviation", MaxDeviationOf(s), "Largest distance of the arm from its target.")
      .OmitIf(s.max_deviation == MaxDeviation());
  map.Add("operator", OptionalSection(s.operator_section, s.places.device),
          "Device that leads the robot in an application that is led.");
}

}  // namespace

void Describe(Map& map, Scenario& s) {
  map.Before([&map](const YamlNode& /*node*/) {
    if (const auto robots = map.Given("robots")) return Robots().read(*robots);
    if (!map.Given("application")) return (void)map.MustBeGiven("motion");
    if (const auto motion = map.Given("motion")) {
      motion->Fail("beside an application, which makes its motions itself; leave one of them out");
    }
  });
  map.DescribeOneOf({"motion", "application", "robots"});
  map.ReadLast({"tick", "controller"});
  AddWhatIsRun(map, s);
  AddWhatIsThere(map, s);
  map.Add("robots", Robots(),
          "Several robots in one scene, by their names, in place of one: the keys of each.");
  AddWhatMoves(map, s);
  const auto perturbation = [](plant::Perturbation& p) { return SectionOf(p, Style::kBare); };
  map.Add("perturbations", List(s.perturbations, perturbation, Style::kBlock),
          "Forces from outside; not on the ideal plant.");
  map.Add("panel", Panel(s.panel), "Actions at the robot's switches, in order of time.");
  map.Add("hand", Hand(s.hand), "Commands to the mounted hand, in order of time.");
  map.Add("render", SectionOf(s.render, Style::kBlock), "The video.");
  map.Add("record", Bool(s.record), "Whether the log, and plots from it, are written.");
}

Scenario ReadScenario(const YamlNode& root, const std::filesystem::path& folder, bool stands) {
  Scenario scenario;
  scenario.places.folder = folder;
  Map map;
  Describe(map, scenario);
  if (stands && !root.Member("robots")) {
    map.Before([](const YamlNode& /*node*/) {});  // it needs nothing that moves it
  }
  if (const auto robot = root.Member("robot")) ReadProfile(*robot, scenario);
  map.Read(root);
  if (stands) {
    if (!scenario.robot.q_start) {
      root.Fail("nothing says where the arm stands: give robot.q_start, or a motion");
    }
    scenario.motion.waypoints.assign(2, {.q = *scenario.robot.q_start});
  }
  root.Checked([&scenario] { scenario.Validate(); });
  return scenario;
}

namespace {

Scenario ReadServed(const YamlNode& root, const std::filesystem::path& folder) {
  const bool moves = root.Member("motion") || root.Member("application");
  return ReadScenario(root, folder, !moves);
}

}  // namespace

Scenario Load(const std::filesystem::path& path) {
  return ReadScenario(YamlNode::ParseFile(path.string()), path.parent_path(), false);
}

Scenario LoadServed(const std::filesystem::path& path) {
  return ReadServed(YamlNode::ParseFile(path.string()), path.parent_path());
}

Scenario ParseServed(const std::string& text, const std::filesystem::path& file) {
  return ReadServed(YamlNode::Parse(text, file.string()), file.parent_path());
}

Scenario Parse(const std::string& text, const std::filesystem::path& file) {
  return ReadScenario(YamlNode::Parse(text, file.string()), file.parent_path(), false);
}

std::string ToYaml(const Scenario& scenario) {
  Scenario copy = scenario;  // a map is bound to variables that it may change
  Map map;
  Describe(map, copy);
  return map.Write(0).substr(1) + "\n";
}

}  // namespace twin::scenario
