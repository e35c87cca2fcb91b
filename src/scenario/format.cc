#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenario/sections.h"

namespace twin::scenario {
namespace {

constexpr std::string_view kHead =
    R"(# Keys of a scenario

`panda-twin schema --keys` writes this file, from the code that reads scenarios; a test compares the two.
A list takes as many items as there are; `[]` stands for each of them. README.md explains the sections.
)";

Json SchemaOfScenario() {
  Scenario scenario;
  Map map;
  Describe(map, scenario);
  Json definitions = Json::object();
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}};
  Json keys;
  map.Schema(keys, definitions);
  schema.update(keys);
  schema["$defs"] = std::move(definitions);
  return schema;
}

/// What a key takes, in words.
std::string KindOf(const Json& schema) {
  if (schema.contains("$ref")) {
    const std::string ref = schema["$ref"];
    return fmt::format("[{0}](#{0})", ref.substr(ref.rfind('/') + 1));
  }
  if (schema.contains("const")) return fmt::format("`{}`", schema["const"].get<std::string>());
  std::string title = schema.value("title", "");
  if (title == "list") return "list of " + KindOf(schema["items"]);
  if (!schema.contains("anyOf")) return title;
  std::string kinds;
  for (const Json& one : schema["anyOf"]) kinds += (kinds.empty() ? "" : ", or ") + KindOf(one);
  return kinds;
}

/// A default as YAML in one line.
std::string DefaultOf(const Json& property) {
  std::string text;
  for (const char c : property["default"].dump()) {
    if (c != '"') text += c;
    if (c == ',' || c == ':') text += ' ';
  }
  return text.empty() ? "\"\"" : text;
}

/// A row for each key of a map, of the items of a list, or of alternatives.
std::string Rows(const std::string& path, const Json& schema) {
  std::string rows;
  if (schema.contains("anyOf")) {
    for (const Json& one : schema["anyOf"]) rows += Rows(path, one);
  }
  if (schema.value("title", "") == "list") return Rows(path + "[]", schema["items"]);
  if (schema.value("title", "") != "map") return rows;
  const Json required = schema.value("required", Json::array());
  for (const auto& [key, property] : schema["properties"].items()) {
    const std::string inside = path.empty() ? key : fmt::format("{}.{}", path, key);
    const bool is_required = std::find(required.begin(), required.end(), key) != required.end();
    const std::string otherwise = is_required ? "required"
                                  : property.contains("default")
                                      ? fmt::format("`{}`", DefaultOf(property))
                                      : "";
    const std::string below = Rows(inside, property);
    const bool has_table = path.empty() && !below.empty();
    rows += fmt::format("| `{}` | {} | {} | {} |\n", inside,
                        has_table ? fmt::format("[{0}](#{0})", key) : KindOf(property), otherwise,
                        property.value("description", ""));
    if (!has_table) rows += below;
  }
  return rows;
}

std::string Table(std::string_view heading, std::string_view meaning, const std::string& rows) {
  if (rows.empty()) return {};
  return fmt::format("\n## {}\n\n{}\n\n| key | value | default | meaning |\n|---|---|---|---|\n{}",
                     heading, meaning, rows);
}

}  // namespace

std::string JsonSchema() {
  return SchemaOfScenario().dump(2) + "\n";
}

std::string KeyTable() {
  const Json schema = SchemaOfScenario();
  std::string text(kHead);
  text += Table("scenario", "One of motion, application and robots is required.", Rows("", schema));
  for (const auto& [key, property] : schema["properties"].items()) {
    text += Table(key, property.value("description", ""), Rows(key, property));
  }
  for (const auto& [name, definition] : schema["$defs"].items()) {
    text += Table(name, definition.value("description", "") + " Value: " + KindOf(definition) + ".",
                  Rows(name, definition));
  }
  return text;
}

}  // namespace twin::scenario
