#include "twin/scenario/sweep_file.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "scenario/sections.h"

namespace twin::scenario {
namespace {

constexpr std::uint64_t kMost = 1'000'000;

/// "0.5 %" as a number and a unit.
SweepNumber NumberIn(const YamlNode& node) {
  const std::string& text = node.Scalar("a number, with the key's unit");
  constexpr std::string_view kNumber = "+-0123456789.eE";
  std::size_t end = std::min(text.find_first_not_of(kNumber), text.size());
  const std::size_t unit = text.find_first_not_of(' ', end);
  const double value = node.Checked([&] { return ParseNumber(text.substr(0, end)); });
  return {value, unit == std::string::npos ? "" : text.substr(unit)};
}

Value Number(SweepNumber& number) {
  Value value = Anything();
  value.read = [&number](const YamlNode& node) { number = NumberIn(node); };
  return value;
}

void RequireOneUnit(const YamlNode& node, const SweepNumber& a, const SweepNumber& b) {
  if (a.unit == b.unit) return;
  node.Fail(fmt::format("\"{}\" and \"{}\": both numbers must have the same unit", Shown(a.unit),
                        Shown(b.unit)));
}

/// @param normal  whether it is one: mean and deviation; else uniform: from and to.
SweepDraw DrawIn(const YamlNode& node, bool normal) {
  SweepDraw draw{.is_normal = normal, .first = {}, .second = {}};
  Map map;
  map.Require(normal ? "mean" : "from", Number(draw.first));
  map.Require(normal ? "deviation" : "to", Number(draw.second));
  map.Read(node);
  RequireOneUnit(node, draw.first, draw.second);
  if (normal ? !(draw.second.value > 0) : !(draw.first.value < draw.second.value)) {
    node.Fail(normal ? "deviation must be above 0" : "from must be below to");
  }
  return draw;
}

void RequireRange(const YamlNode& node, const SweepRange& range) {
  RequireOneUnit(node, range.from, range.to);
  if (!(range.from.value < range.to.value)) node.Fail("from must be below to");
  if (range.is_logarithmic && !(range.from.value > 0)) node.Fail("scale log takes from above 0");
}

bool IsKey(const std::string& key) {
  const bool has_letters =
      std::ranges::all_of(key, [](char c) { return IsNameLetter(c) || c == '.'; });
  return !key.empty() && has_letters && !key.starts_with('.') && !key.ends_with('.') &&
         key.find("..") == std::string::npos;
}

/// @throws InputError unless the axis says its values in exactly one way.
void RequireOneWay(const YamlNode& node) {
  constexpr std::array<std::string_view, 4> kWays{"values", "from", "uniform", "normal"};
  const auto given = std::ranges::count_if(
      kWays, [&node](std::string_view way) { return node.Member(way).has_value(); });
  if (given != 1) node.Fail("give exactly one of values, from and to, uniform, normal");
  for (const char* of_range : {"to", "steps", "scale"}) {
    if (node.Member(of_range) && !node.Member("from")) {
      node.Fail(fmt::format("{} goes with from", of_range));
    }
  }
}

SweepAxis AxisIn(const YamlNode& node) {
  SweepAxis axis;
  SweepRange range;
  Value values = Anything();
  values.read = [&axis](const YamlNode& list) {
    if (list.IsMap()) {
      for (const auto& [name, item] : list.Entries()) {
        axis.names.push_back(name);
        axis.values.push_back(item.FlowText());
      }
      return;
    }
    for (const YamlNode& item : list.Items()) axis.values.push_back(item.FlowText());
    if (axis.values.empty()) list.Fail("is empty; give at least one value");
  };
  const auto draw = [&axis](bool normal) {
    Value value = Anything();
    value.read = [&axis, normal](const YamlNode& of) { axis.draw = DrawIn(of, normal); };
    return value;
  };
  const std::vector<std::string_view> scales{"linear", "log"};
  Map map;
  map.Require("key", Text(axis.key), "Of the scenario, dotted.");
  map.Add("values", values, "Any values.");
  map.Add("from", Number(range.from), "First of a range.");
  map.Add("to", Number(range.to), "Last of a range.");
  map.Add("steps", Integer(range.steps, 2, 10000), "Values of the range in a grid.");
  map.Add("scale", OneOfNames(
                       scales, [&range](std::size_t i) { range.is_logarithmic = i == 1; },
                       [] { return 0; }));
  map.Add("uniform", draw(false), "Drawn for each run.");
  map.Add("normal", draw(true), "Drawn for each run.");
  map.Read(node);
  if (!IsKey(axis.key)) {
    node.Fail(
        fmt::format("key \"{}\": a key of the scenario with dots belongs here, such as "
                    "link.command_loss",
                    Shown(axis.key)));
  }
  if (axis.key == "seed") node.Fail("key seed: every run has its own; say seeds and first_seed");
  RequireOneWay(node);
  if (!node.Member("from")) return axis;
  if (!node.Member("to")) node.Fail("from goes with to");
  RequireRange(node, range);
  axis.range = range;
  return axis;
}

/// @throws InputError when an axis replaces what one before it says: tick behind tick.lambda.
void RequireOrder(const YamlNode& node, const SweepFile& sweep, const SweepAxis& axis) {
  for (const SweepAxis& before : sweep.axes) {
    if (before.key == axis.key) node.Fail(fmt::format("key {} has an axis already", axis.key));
    if (!before.key.starts_with(axis.key + ".")) continue;
    node.Fail(fmt::format("key {} replaces what the axis {} says; put it before that", axis.key,
                          before.key));
  }
}

Value Axes(SweepFile& sweep) {
  Value value = Anything();
  value.read = [&sweep](const YamlNode& node) {
    for (const YamlNode& item : node.Items()) {
      SweepAxis axis = AxisIn(item);
      RequireOrder(item, sweep, axis);
      sweep.axes.push_back(std::move(axis));
    }
    if (sweep.axes.empty()) node.Fail("is empty; give at least one axis");
  };
  return value;
}

Value Samples(SweepFile& sweep) {
  return Section([&sweep](Map& map) {
    Value kind = Anything();
    kind.read = [&sweep](const YamlNode& node) {
      constexpr std::array<std::string_view, 2> kKinds{"latin_hypercube", "sobol"};
      sweep.has_sobol_samples = node.Choice(kKinds) == 1;
    };
    map.Require("kind", kind);
    map.Require("points", Optional(sweep.samples, [](std::uint64_t& points) {
                  return Integer(points, 1, kMost);
                }));
  });
}

/// Ranges have steps in a grid, and none in samples, which have no lists.
void RequireSampling(const YamlNode& root, const SweepFile& sweep) {
  for (const SweepAxis& axis : sweep.axes) {
    if (sweep.samples && !axis.values.empty()) {
      root.Fail(fmt::format("axis {}: samples takes ranges, not values", axis.key));
    }
    if (!axis.range || (axis.range->steps > 0) != sweep.samples.has_value()) continue;
    root.Fail(fmt::format("axis {}: {}", axis.key,
                          sweep.samples ? "samples says how many points; leave steps out"
                                        : "a range in a grid needs steps"));
  }
}

}  // namespace

SweepFile LoadSweep(const std::filesystem::path& path) {
  SweepFile sweep;
  sweep.folder = path.parent_path();
  Map map;
  map.Require("name", Identifier(sweep.name), "Names the folder of results.");
  map.Add("description", Text(sweep.description), "Description for people.");
  map.Require("scenario",
              Converted(std::string(), Text, [&](auto& text) { sweep.scenario = text; }),
              "What is run.");
  map.Require("axes", Axes(sweep), "What is varied.");
  map.Add("samples", Samples(sweep),
          "Points of a Latin hypercube or a Sobol sequence in place of a grid.");
  map.Add("seed", Seed(sweep.seed), "Of what the sweep draws.");
  map.Add("seeds", Integer(sweep.seeds, 1, kMost), "Runs of each point.");
  map.Add("first_seed", Seed(sweep.first_seed), "Of the first run.");
  const std::vector<std::string_view> kept{"summary", "failures", "all"};
  map.Add("keep",
          OneOfNames(
              kept, [&sweep](std::size_t i) { sweep.keep = static_cast<SweepFile::Keep>(i); },
              [&sweep] { return static_cast<int>(sweep.keep); }),
          "Of which runs logs are kept.");
  map.Add("stop_at_width",
          Optional(sweep.stop_at_width, [](double& width) { return Number(width, 0.001, 1); }),
          "Width of the confidence interval at which a point ends.");
  map.Add("demand", Section([&sweep](Map& of) {
            of.Require("success", Optional(sweep.least_success_percent, [](double& percent) {
                         return Quantity(percent, Dimension::kPercent, 0, 100);
                       }));
          }),
          "Share of all runs that must succeed.");
  map.Add("budget",
          Optional(sweep.budget, [](std::uint64_t& runs) { return Integer(runs, 1, ~0ULL); }),
          "Greatest number of runs.");
  const YamlNode root = YamlNode::ParseFile(path.string());
  map.Read(root);
  root.Checked([&map] { map.Check(""); });
  RequireSampling(root, sweep);
  return sweep;
}

}  // namespace twin::scenario
