#include "twin/scenario/video_case.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "scenario/section_readers.h"
#include "scenario/yaml_node.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

bool IsName(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

VideoView ReadView(const std::string& name, const YamlNode& node) {
  if (!IsName(name)) {
    node.Fail(fmt::format("\"{}\": a view's name has letters, digits, '_' and '-' only", name));
  }
  VideoView view{name, {}};
  view.render.width = kWidth;
  view.render.height = kHeight;
  ReadRender(node, view.render);
  try {
    view.render.Validate();
  } catch (const InputError& error) {
    node.Fail(error.what());
  }
  return view;
}

}  // namespace

VideoCase LoadVideoCase(const std::filesystem::path& path) {
  const YamlMap root = YamlNode::ParseFile(path.string())
                           .Map({"scenario", "lab", "seed", "every", "key_frames", "views"});
  VideoCase wanted;
  wanted.name = path.stem().string();
  wanted.scenario = root.Require("scenario").Text();
  IfGiven(root, "lab", [&](const YamlNode& n) { wanted.lab = n.Text(); });
  IfGiven(root, "seed", [&](const YamlNode& n) {
    wanted.seed = n.Integer(0, std::numeric_limits<std::uint64_t>::max());
  });
  IfGiven(root, "every", [&](const YamlNode& n) { wanted.every = n.Integer(1, 10000); });
  IfGiven(root, "key_frames", [&](const YamlNode& n) { wanted.key_frames = n.Integer(2, 100); });
  for (const auto& [name, node] : root.Require("views").Entries()) {
    wanted.views.push_back(ReadView(name, node));
  }
  return wanted;
}

}  // namespace twin::scenario
