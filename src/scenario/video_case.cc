#include "twin/scenario/video_case.h"

#include <algorithm>

#include <fmt/format.h>

#include "scenario/sections.h"

namespace twin::scenario {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

VideoView ReadView(const std::string& name, const YamlNode& node) {
  if (name.empty() || !std::ranges::all_of(name, IsNameLetter)) {
    node.Fail(fmt::format("\"{}\": a view's name has letters, digits, '_' and '-' only", name));
  }
  VideoView view{name, {}};
  view.render.width = kWidth;
  view.render.height = kHeight;
  SectionOf(view.render).read(node);
  node.Checked([&view] { view.render.Validate(); });
  return view;
}

}  // namespace

VideoCase LoadVideoCase(const std::filesystem::path& path) {
  VideoCase wanted;
  wanted.name = path.stem().string();
  Map map;
  map.Require("scenario",
              Converted(std::string(), Text, [&](auto& text) { wanted.scenario = text; }),
              "In the models folder.");
  map.Add("lab", Optional(wanted.lab, Text), "Laid over it.");
  map.Add("seed", Optional(wanted.seed, Seed), "Absent: the scenario's.");
  map.Add("every", Integer(wanted.every, 1, 10000), "Frame that is looked at.");
  map.Add("key_frames", Integer(wanted.key_frames, 2, 100), "Frames that are kept whole.");
  Value views = Anything();
  views.read = [&wanted](const YamlNode& node) {
    for (const auto& [name, view] : node.Entries()) wanted.views.push_back(ReadView(name, view));
  };
  map.Require("views", views, "From where it is seen, by name.");
  map.Read(YamlNode::ParseFile(path.string()));
  return wanted;
}

}  // namespace twin::scenario
