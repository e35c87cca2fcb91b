#include "twin/scenario/profile.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "scenario/profile_draw.h"
#include "scenario/sections.h"
#include "twin/core/content_hash.h"

namespace twin::scenario {
namespace {

std::filesystem::path FindProfile(const YamlNode& named, const std::filesystem::path& folder) {
  const std::filesystem::path name = named.Text();
  std::error_code none;
  for (const auto& place : {folder / name, folder / ".." / "profiles" / name}) {
    if (std::filesystem::is_regular_file(place, none)) {
      return std::filesystem::absolute(place).lexically_normal();
    }
  }
  named.Fail(
      fmt::format("there is no file {}; give a profile beside the scenario, in a folder "
                  "profiles beside its own, or its absolute path",
                  (folder / name).string()));
}

std::string HashOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  ContentHash hash;
  hash.Add(std::string{std::istreambuf_iterator<char>(in), {}});
  return hash.Hex();
}

Value HoldsFor(Profile& profile) {
  return Section([&profile](Map& map) {
    map.Add("speed", Optional(profile.speed, [](JointVector& dq) {
              return Joints(dq, Dimension::kAngularVelocity);
            }));
    map.Add("load", Section([&profile](Map& load) {
              load.Require("from", Quantity(profile.least_load, Dimension::kMass, 0, 100));
              load.Require("to", Quantity(profile.most_load, Dimension::kMass, 0, 100));
            }));
  });
}

Value Version() {
  Value version = Anything();
  version.read = [](const YamlNode& node) {
    if (node.Text() == "1") return;
    node.Fail(fmt::format("\"{}\": this program reads version 1 of profiles", Shown(node.Text())));
  };
  return version;
}

Value RobotOf(const std::string& model) {
  Value robot = Anything();
  robot.read = [model](const YamlNode& node) {
    if (node.Text() == model) return;
    node.Fail(fmt::format("the profile is of \"{}\", the scenario's robot is \"{}\"; name another",
                          Shown(node.Text()), Shown(model)));
  };
  return robot;
}

/// The sections of a scenario that a profile has.
Value Keys(Scenario& scenario, bool has_load) {
  return Section([&scenario, has_load](Map& map) {
    map.Add("plant", SectionOf(scenario.plant));
    map.Add("link", SectionOf(scenario.link));
    map.Add("robot", Section([&scenario, has_load](Map& robot) {
              Value load = LoadOf(scenario.robot.load);
              // The scenario's own load is another body: no key of this one counts beside it.
              if (has_load)
                load.read = [](const YamlNode& node) {
                  setting::Load unused;
                  LoadOf(unused).read(node);
                };
              robot.Add("load", load);
            }));
  });
}

std::uint64_t DrawIn(const YamlNode& robot) {
  std::uint64_t draw = 0;
  if (const auto node = robot.Member("profile_draw")) {
    Integer(draw, 0, 1'000'000'000).read(*node);
  }
  return draw;
}

}  // namespace

void ReadProfile(const YamlNode& robot, Scenario& scenario) {
  const auto named = robot.Member("profile");
  if (!named) {
    if (DrawIn(robot) > 0) robot.Member("profile_draw")->Fail("goes with robot.profile");
    return;
  }
  Profile profile;
  profile.file = FindProfile(*named, scenario.places.folder);
  profile.hash = HashOf(profile.file);
  const auto model = robot.Member("model");
  const bool has_load = robot.Member("load").has_value();
  std::optional<YamlNode> covariance;
  Value drawn = Anything();
  drawn.read = [&covariance](const YamlNode& node) { covariance = node; };
  Map map;
  map.Require("profile", Version());
  map.Require("robot", RobotOf(model ? model->Text() : scenario.robot.model));
  map.Add("identified", Anything());
  map.Add("holds_for", HoldsFor(profile));
  map.Require("scenario", Keys(scenario, has_load));
  map.Add("covariance", drawn);
  const YamlNode root = YamlNode::ParseFile(profile.file.string());
  map.Read(root);
  if (covariance) {
    const Covariance of = CovarianceIn(*covariance);
    const std::uint64_t seed = std::stoull(profile.hash.substr(0, 16), nullptr, 16);
    if (const std::uint64_t draw = DrawIn(robot)) {
      const setting::Load own = scenario.robot.load;
      covariance->Checked([&] { Draw(of, seed, draw, scenario); });
      if (has_load) scenario.robot.load = own;
    }
  } else if (DrawIn(robot) > 0) {
    root.Fail("has no covariance to draw from, as robot.profile_draw demands");
  }
  root.Checked([&] { plant::Validate(scenario.plant.arm, scenario.plant.armature); },
               "scenario.plant.");
  scenario.places.profile = std::move(profile);
}

std::string Profile::Excess(const JointVector& motion, double load) const {
  constexpr double kMargin = 1.01;  // speeds of profiles are measured ones
  const std::string name = file.filename().string();
  for (std::size_t i = 0; speed && i < kJoints; ++i) {
    if (motion[i] <= kMargin * (*speed)[i]) continue;
    return fmt::format(
        "profile {}: joint {} moves at up to {:.3g} rad/s; the profile holds for {:.3g} rad/s",
        name, i + 1, motion[i], (*speed)[i]);
  }
  if (load >= least_load / kMargin - 1e-3 && load <= kMargin * most_load + 1e-3) return {};
  return fmt::format("profile {}: the load is {:.3g} kg; the profile holds for {:.3g} to {:.3g} kg",
                     name, load, least_load, most_load);
}

}  // namespace twin::scenario
