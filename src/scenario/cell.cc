#include "twin/scenario/cell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenario/sections.h"
#include "twin/core/error.h"
#include "twin/core/random.h"

namespace twin::scenario {
namespace {

constexpr std::array<std::string_view, 8> kCommonKeys{"name",  "description", "seed",   "drive",
                                                      "scene", "objects",     "render", "record"};
/// What a robot has of the scene's when it is read.
constexpr std::array<std::string_view, 4> kHandedDown{"name", "drive", "scene", "record"};
constexpr std::array<std::string_view, 15> kRobotKeys{
    "seed",    "loop",          "robot",         "plant",  "link",
    "onboard", "tick",          "controller",    "motion", "application",
    "limits",  "max_deviation", "perturbations", "panel",  "hand"};
/// Of one robot alone.
constexpr std::array<std::string_view, 3> kKeysOfOne{"backend", "base", "operator"};
/// Names of folders in that of a run.
constexpr std::array<std::string_view, 3> kTaken{"plots", "motions", "snapshots"};

/// Height over which two bases at one place overlap, m: up to joint 2.
constexpr double kBaseHeight = 0.333;

bool Holds(std::span<const std::string_view> keys, std::string_view key) {
  return std::ranges::find(keys, key) != keys.end();
}

void RefuseKeysOfOne(const YamlNode& root) {
  for (const std::string_view key : kRobotKeys) {
    if (key == "seed") continue;
    if (const auto beside = root.Member(key)) {
      beside->Fail("beside robots, each of which has its own; move it to a robot of robots");
    }
  }
  for (const std::string_view key : kKeysOfOne) {
    if (const auto beside = root.Member(key)) {
      beside->Fail("is of one robot alone; leave it out, or describe one robot without robots");
    }
  }
}

void RequireName(const std::string& name, const YamlNode& node) {
  const bool is_name =
      !name.empty() && name.size() <= 24 && std::ranges::all_of(name, IsNameLetter);
  if (!is_name) {
    node.Fail("the name of a robot takes 1 to 24 letters, digits, '_' and '-'");
  }
  if (Holds(kTaken, name)) node.Fail("a folder of results is called so; take another name");
}

Scenario ReadCommon(const YamlNode& root, const std::filesystem::path& folder) {
  Scenario common;
  common.places.folder = folder;
  Map map;
  Describe(map, common);
  map.Retain(kCommonKeys);
  map.Before([](const YamlNode& /*node*/) {});
  map.Add("robots", Anything());
  map.Read(root);
  return common;
}

/// What the shared plant asks of a robot.
void RequireShareable(const CellRobot& robot, const CellRobot& first, const YamlNode& node) {
  const PlantSection& plant = robot.scenario.plant;
  if (plant.kind == robot::PlantKind::kIdeal) {
    node.Fail("plant.kind: the ideal plant touches nothing; of several robots say mujoco");
  }
  if (!(plant.base_tilt == plant::BaseTilt())) {
    node.Fail("plant.base_tilt: it tilts one robot's world; leave it out");
  }
  if (robot.scenario.robot.clock_drift_ppm != first.scenario.robot.clock_drift_ppm) {
    node.Fail(fmt::format(
        "robot.clock_drift: {} ppm, and that of {} is {} ppm; the robots of a scene take its steps "
        "together: give all the same",
        robot.scenario.robot.clock_drift_ppm, first.name, first.scenario.robot.clock_drift_ppm));
  }
}

void RequireApart(const CellRobot& robot, std::span<const CellRobot> others, const YamlNode& node) {
  const Vector3& p = robot.scenario.robot.pose.position;
  for (const CellRobot& other : others) {
    const Vector3& o = other.scenario.robot.pose.position;
    const double distance = std::hypot(p[0] - o[0], p[1] - o[1]);
    if (distance >= kLeastBaseDistance || std::abs(p[2] - o[2]) >= kBaseHeight) continue;
    node.Fail(fmt::format(
        "its base stands {:.3f} m from that of {}, and they overlap; put them {} m apart at least "
        "(robot: {{pose: {{position: [x m, y m, z m]}}}})",
        distance, other.name, kLeastBaseDistance));
  }
}

CellRobot ReadRobot(const std::string& name, const YamlNode& node, const YamlNode& root,
                    const Scenario& common, bool is_served) {
  RequireName(name, node);
  static_cast<void>(node.Map(kRobotKeys));
  YamlNode::Members handed;
  for (const std::string_view key : kHandedDown) {
    if (auto member = root.Member(key)) handed.emplace_back(key, *std::move(member));
  }
  CellRobot robot{
      .name = name,
      .scenario = ReadScenario(node.With(handed), common.places.folder,
                               is_served && !node.Member("motion") && !node.Member("application")),
      .where = node.Where()};
  Scenario& scenario = robot.scenario;
  scenario.name = fmt::format("{}_{}", common.name, name);
  if (!node.Member("seed")) scenario.seed = SeedOf(common.seed, name);
  scenario.objects = DrawnFrom(common.objects, common.seed);
  scenario.render = RenderSection();
  scenario.render.enabled = false;
  scenario.render.fps = common.render.fps;
  node.Checked([&scenario] { scenario.Validate(); });
  return robot;
}

Cell ReadCell(const YamlNode& root, const std::filesystem::path& folder,
              std::optional<std::uint64_t> seed, bool is_served) {
  const auto robots = root.Member("robots");
  if (!robots) root.Fail("key \"robots\" is missing: it describes one robot");
  RefuseKeysOfOne(root);
  Cell cell{.common = ReadCommon(root, folder), .robots = {}};
  if (seed) cell.common.seed = *seed;
  root.Checked([&cell] { static_cast<void>(ObjectsOf(cell.common.objects, cell.common.seed)); });
  // Nodes of yaml-cpp must not be assigned, as a sort of them would: that changes the document.
  const YamlNode::Members members = robots->Entries();
  std::map<std::string_view, const YamlNode*> by_name;
  for (const auto& [name, node] : members) by_name.emplace(name, &node);
  for (const auto& [given, found] : by_name) {
    const std::string name(given);
    const YamlNode& node = *found;
    CellRobot robot = ReadRobot(name, node, root, cell.common, is_served);
    if (!cell.robots.empty()) RequireShareable(robot, cell.robots.front(), node);
    if (cell.robots.empty()) RequireShareable(robot, robot, node);
    RequireApart(robot, cell.robots, node);
    cell.robots.push_back(std::move(robot));
  }
  return cell;
}

}  // namespace

Value Robots() {
  Value robots;
  robots.read = [](const YamlNode& node) {
    node.Fail(
        "several robots; the commands run, validate, serve and render and Python's "
        "panda_twin.Cell take such a scenario, and this one takes one robot");
  };
  robots.schema = [](Json& schema, Json& /*definitions*/) {
    schema = {
        {"title",
         "map of a name and these keys: seed, loop, robot, plant, link, onboard, "
         "tick, controller, motion, application, limits, max_deviation, perturbations, panel, "
         "hand"},
        {"type", "object"},
        {"minProperties", 1}};
    Json& robot = schema["additionalProperties"];
    robot = {{"type", "object"}, {"additionalProperties", false}};
    for (const std::string_view key : kRobotKeys) {
      robot["properties"][std::string(key)]["$ref"] = fmt::format("#/properties/{}", key);
    }
  };
  return robots;
}

std::uint64_t SeedOf(std::uint64_t cell_seed, std::string_view robot) noexcept {
  // FNV-1a of the name counts the draws.
  std::uint64_t number = 14695981039346656037ULL;
  for (const char c : robot) number = (number ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  const auto bits = Random(cell_seed, RandomStream::kRobotSeed).Bits(number);
  return static_cast<std::uint64_t>(bits[0]) << 32 | bits[1];
}

bool HasRobots(const std::filesystem::path& path) {
  return YamlNode::ParseFile(path.string()).Member("robots").has_value();
}

Cell LoadCell(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  return ReadCell(YamlNode::ParseFile(path.string()), path.parent_path(), seed, false);
}

Cell LoadServedCell(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  return ReadCell(YamlNode::ParseFile(path.string()), path.parent_path(), seed, true);
}

Cell ParseCell(const std::string& text, const std::filesystem::path& file) {
  return ReadCell(YamlNode::Parse(text, file.string()), file.parent_path(), {}, false);
}

Cell ParseServedCell(const std::string& text, const std::filesystem::path& file,
                     std::optional<std::uint64_t> seed) {
  return ReadCell(YamlNode::Parse(text, file.string()), file.parent_path(), seed, true);
}

std::string ToYaml(const Cell& cell) {
  const auto text = [](Scenario scenario, std::span<const std::string_view> keys, int indent) {
    Map map;
    Describe(map, scenario);
    map.Retain(keys);
    return map.Write(indent);
  };
  std::string yaml = text(cell.common, kCommonKeys, 0).substr(1) + "\nrobots:";
  for (const CellRobot& robot : cell.robots) {
    yaml += fmt::format("\n  {}:{}", robot.name, text(robot.scenario, kRobotKeys, 4));
  }
  return yaml + "\n";
}

}  // namespace twin::scenario
