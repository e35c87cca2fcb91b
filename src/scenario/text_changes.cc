#include "twin/scenario/text_changes.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>
#include <nlohmann/json.hpp>

#include "scenario/yaml_node.h"

namespace twin::scenario {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// The whole document. YamlNode says what is wrong with a text.
YAML::Node MapIn(const std::string& text, const std::string& file) {
  const YamlNode node = YamlNode::Parse(text, file);
  if (!node.IsMap()) node.Fail("a map of a scenario's keys belongs here");
  return node.tree();
}

/// The value of a key; none when the map has no such key.
std::optional<YAML::Node> ValueOf(const YAML::Node& map, const std::string& key) {
  for (const auto& item : map) {
    if (item.first.IsScalar() && item.first.Scalar() == key) return YAML::Node(item.second);
  }
  return std::nullopt;
}

/// Makes a new map and changes neither: two keys may share a value by an alias.
YAML::Node Merged(const YAML::Node& base, const YAML::Node& over) {
  YAML::Node merged(YAML::NodeType::Map);
  for (const auto& item : base) {
    const std::optional<YAML::Node> value =
        item.first.IsScalar() ? ValueOf(over, item.first.Scalar()) : std::nullopt;
    if (!value) {
      merged.force_insert(item.first, item.second);
    } else if (value->IsMap() && item.second.IsMap()) {
      merged.force_insert(item.first, Merged(item.second, *value));
    } else if (!value->IsNull()) {
      merged.force_insert(item.first, *value);
    }
  }
  for (const auto& item : over) {
    const bool is_new = !item.first.IsScalar() || !ValueOf(base, item.first.Scalar());
    if (is_new && !item.second.IsNull()) merged.force_insert(item.first, item.second);
  }
  return merged;
}

/// A plain scalar by its spelling.
OrderedJson PlainJson(const std::string& text) {
  if (text == "true") return true;
  if (text == "false") return false;
  if (text.empty() || text == "null" || text == "~") return nullptr;
  const char* const end = text.data() + text.size();
  std::int64_t whole = 0;
  if (const auto read = std::from_chars(text.data(), end, whole);
      read.ec == std::errc() && read.ptr == end) {
    return whole;
  }
  std::uint64_t natural = 0;  // seeds go up to 2^64 - 1
  if (const auto read = std::from_chars(text.data(), end, natural);
      read.ec == std::errc() && read.ptr == end) {
    return natural;
  }
  double number = 0;
  if (const auto read = std::from_chars(text.data(), end, number);
      read.ec == std::errc() && read.ptr == end && std::isfinite(number)) {
    return number;
  }
  return text;
}

OrderedJson JsonOf(const YAML::Node& node) {
  if (node.IsMap()) {
    OrderedJson map = OrderedJson::object();
    for (const auto& item : node) map[item.first.Scalar()] = JsonOf(item.second);
    return map;
  }
  if (node.IsSequence()) {
    OrderedJson list = OrderedJson::array();
    for (const auto& item : node) list.push_back(JsonOf(item));
    return list;
  }
  constexpr std::string_view kQuoted = "!";
  return node.Tag() == kQuoted ? OrderedJson(node.Scalar()) : PlainJson(node.Scalar());
}

/// Calls `work`, which no exception of yaml-cpp leaves.
template <typename Work>
std::string Guarded(const std::filesystem::path& file, Work work) {
  try {
    return work();
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}: not valid YAML: {}", file.string(), error.msg));
  }
}

}  // namespace

std::string WithChanges(const std::string& text, const std::filesystem::path& file,
                        const std::vector<std::string>& changes) {
  return Guarded(file, [&] {
    YAML::Node tree = MapIn(text, file);
    for (const std::string& one : changes) tree.reset(Merged(tree, MapIn(one, "changes")));
    return YAML::Dump(tree) + "\n";
  });
}

std::string WithChanges(const std::string& text, const std::filesystem::path& file,
                        const std::string& changes) {
  return WithChanges(text, file, std::vector{changes});
}

std::string ToJson(const std::string& text, const std::filesystem::path& file) {
  return Guarded(file, [&] { return JsonOf(MapIn(text, file)).dump(); });
}

}  // namespace twin::scenario
