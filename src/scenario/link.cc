#include "twin/scenario/link.h"

#include "scenario/sections.h"

namespace twin::scenario {

robot::DirectionConfig MakeDirection(const DirectionSection& section) {
  robot::DirectionConfig config;
  config.delay = section.delay.Model();
  config.loss = section.loss.Model();
  config.duplication = section.duplication.share_percent / 100;
  config.duplicate_delay = section.duplication.delay.Model();
  config.reordering = section.reordering.share_percent / 100;
  config.reorder_by = section.reordering.by;
  return config;
}

robot::LinkConfig MakeLink(const LinkSection& link) {
  robot::LinkConfig config;
  config.state = MakeDirection(link.state);
  config.command = MakeDirection(link.command);
  config.d_INT = link.d_INT;
  return config;
}

LinkSection LoadLink(const std::filesystem::path& path) {
  const YamlNode root = YamlNode::ParseFile(path.string());
  if (root.Member("motion")) return Load(path).link;
  LinkSection link;
  Map map;
  map.Require("link", SectionOf(link));
  map.Read(root);
  return link;
}

LinkSection ParseLink(const std::string& text, const std::filesystem::path& file) {
  LinkSection link;
  SectionOf(link).read(YamlNode::Parse(text, file.string()));
  return link;
}

}  // namespace twin::scenario
