#include "scenario/schema.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "twin/core/error.h"

namespace twin::scenario {
namespace {

/// Converts a default to JSON: numbers and truth values as such, all else as text.
Json FromYaml(const YAML::Node& node) {
  Json json = node.IsMap() ? Json::object() : Json::array();
  for (const auto& item : node) {
    if (node.IsMap()) json[item.first.Scalar()] = FromYaml(item.second);
    if (node.IsSequence()) json.push_back(FromYaml(item));
  }
  if (!node.IsScalar()) return json;
  json = node.Tag() == "!" ? Json() : Json::parse(node.Scalar(), nullptr, false);
  return json.is_number() || json.is_boolean() ? json : Json(node.Scalar());
}

bool Holds(const std::vector<std::string_view>& keys, std::string_view key) {
  return std::ranges::find(keys, key) != keys.end();
}

}  // namespace

Map::Entry& Map::Entry::OmitIf(bool omitted) {
  is_omitted = omitted;
  return *this;
}

Map::Entry& Map::Entry::Then(Hook hook) {
  then = std::move(hook);
  return *this;
}

Map::Entry& Map::Entry::At(Place& place) {
  return Then([&place](const YamlNode& node) { place = {node.Text(), node.Where()}; });
}

Map::Entry& Map::Add(std::string key, Value value, std::string_view meaning) {
  return entries_.emplace_back(
      Entry{.key = std::move(key), .value = std::move(value), .meaning = meaning});
}

Map::Entry& Map::Require(std::string key, Value value, std::string_view meaning) {
  Entry& entry = Add(std::move(key), std::move(value), meaning);
  entry.is_required = true;
  return entry;
}

void Map::RequireAll() {
  for (Entry& entry : entries_) entry.is_required = true;
}

void Map::ExactlyOne(std::string_view other) {
  is_one_of_ = true;
  one_of_ = Keys();
  std::erase(one_of_, other);
}

void Map::Retain(std::span<const std::string_view> keys) {
  std::erase_if(entries_, [keys](const Entry& entry) {
    return std::ranges::find(keys, entry.key) == keys.end();
  });
}

std::vector<std::string_view> Map::Keys() const {
  std::vector<std::string_view> keys;
  for (const Entry& entry : entries_) keys.push_back(entry.key);
  return keys;
}

std::optional<YamlNode> Map::Given(std::string_view key) const {
  for (const auto& [name, node] : given_) {
    if (name == key) return node;
  }
  return std::nullopt;
}

YamlNode Map::MustBeGiven(std::string_view key) const {
  if (auto given = Given(key)) return *given;
  node_->Fail(fmt::format("key \"{}\" is missing", key));
}

void Map::Read(const YamlNode& node) {
  for (const auto& [from, what] : renamed_) {
    if (const auto old = node.Member(from)) old->Fail(what);
  }
  node_ = node;
  given_ = node.Map(Keys());
  if (where_ != nullptr) *where_ = node.Where();
  const auto is_given = [this](std::string_view key) { return Given(key).has_value(); };
  if (is_one_of_ && std::ranges::count_if(one_of_, is_given) != 1) {
    node.Fail(fmt::format("give exactly one of {}", fmt::join(one_of_, ", ")));
  }
  if (before_) before_(node);
  for (const bool is_last : {false, true}) {
    for (const Entry& entry : entries_) {
      if (Holds(last_, entry.key) != is_last) continue;
      const auto value = entry.is_required ? MustBeGiven(entry.key) : Given(entry.key);
      if (!value) continue;
      entry.value.read(*value);
      if (entry.then) entry.then(*value);
    }
  }
}

std::string Map::Write(int indent) const {
  std::string text;
  for (const Entry& entry : entries_) {
    if (entry.is_omitted) continue;
    const std::string value = entry.value.write(indent < 0 ? -1 : indent + 2);
    if (value.empty()) continue;
    if (indent >= 0) text += fmt::format("\n{:{}}", "", indent);
    if (indent < 0 && !text.empty()) text += ", ";
    text += fmt::format("{}:{}{}", entry.key, value.front() == '\n' ? "" : " ", value);
  }
  return text;
}

void Map::Check(const std::string& key) const {
  for (const Entry& entry : entries_) {
    if (!entry.is_omitted) entry.value.check(key.empty() ? entry.key : key + "." + entry.key);
  }
}

void Map::Schema(Json& schema, Json& definitions) const {
  schema = {{"title", "map"}, {"type", "object"}, {"additionalProperties", false}};
  schema["properties"] = Json::object();
  for (const Entry& entry : entries_) {
    Json property;
    entry.value.schema(property, definitions);
    if (!entry.meaning.empty()) property["description"] = entry.meaning;
    const std::string text = entry.value.write(-1);
    if (entry.is_required) {
      schema["required"].push_back(entry.key);
    } else if (!text.empty() && !Holds(one_of_, entry.key) &&
               (text.front() != '{' || property.value("title", "").starts_with("{unit"))) {
      property["default"] = FromYaml(YAML::Load(text));  // the keys of a map have their own
    }
    schema["properties"][entry.key] = std::move(property);
  }
  for (const std::string_view key : one_of_) {
    schema["oneOf"].push_back({{"required", Json::array({key})}});
  }
}

Value Section(const std::function<void(Map&)>& describe, Style style) {
  const auto with = [describe](auto use) {
    Map map;
    describe(map);
    return use(map);
  };
  return {.read = [with](const YamlNode& node) { with([&](Map& map) { map.Read(node); }); },
          .write =
              [with, style](int indent) {
                const bool is_block = style == Style::kBlock && indent >= 0;
                const auto write = [=](Map& map) { return map.Write(is_block ? indent : -1); };
                const std::string text = with(write);
                return is_block || style == Style::kBare ? text : fmt::format("{{{}}}", text);
              },
          .check = [with](const std::string& key) { with([&](Map& map) { map.Check(key); }); },
          .schema =
              [with](Json& schema, Json& definitions) {
                with([&](Map& map) { map.Schema(schema, definitions); });
              }};
}

Value Defined(const std::string& name, std::string_view meaning, Value value) {
  value.schema = [name, meaning, define = value.schema](Json& schema, Json& definitions) {
    schema["$ref"] = "#/$defs/" + name;
    if (definitions.contains(name)) return;
    definitions[name] = nullptr;  // reserves a place before the definitions it uses
    Json definition;
    define(definition, definitions);
    definition["description"] = meaning;
    definitions[name] = std::move(definition);
  };
  return value;
}

Value Validated(Value value, const std::function<void()>& validate) {
  value.read = [read = value.read, validate](const YamlNode& node) {
    read(node);
    node.Checked(validate);
  };
  value.check = [check = value.check, validate](const std::string& key) {
    check(key);
    try {
      validate();
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", key, error.what()));
    }
  };
  return value;
}

std::string ListText(const std::vector<std::string>& items, int indent) {
  if (indent < 0 || items.empty()) return fmt::format("[{}]", fmt::join(items, ", "));
  std::string text;
  for (const std::string& item : items) text += fmt::format("\n{:{}}- {}", "", indent, item);
  return text;
}

void ListSchema(Json& schema, Json& definitions, const Value& item) {
  schema = {{"title", "list"}, {"type", "array"}};
  item.schema(schema["items"], definitions);
}

Value Either(const Value& scalar, const Value& other, const std::function<bool()>& is_scalar) {
  const auto written = [=] { return is_scalar() ? scalar : other; };
  return {.read = [=](const YamlNode& node) { (node.IsScalar() ? scalar : other).read(node); },
          .write = [written](int indent) { return written().write(indent); },
          .check = [written](const std::string& key) { written().check(key); },
          .schema =
              [=](Json& schema, Json& definitions) {
                Json& alternatives = schema["anyOf"] = Json::array({nullptr, nullptr});
                scalar.schema(alternatives[0], definitions);
                other.schema(alternatives[1], definitions);
              }};
}

Value OrWord(std::string_view word, const std::function<bool()>& is_word,
             const std::function<void()>& set_word, const Value& other) {
  const Value constant{.read = {},
                       .write = [word](int /*indent*/) { return std::string(word); },
                       .schema =
                           [word](Json& schema, Json&) {
                             schema = {{"const", word}};
                           }};
  Value value = Either(constant, other, is_word);
  value.read = [word, set_word, read = other.read](const YamlNode& node) {
    const bool is_given = node.IsScalar() && node.Text() == word;
    is_given ? set_word() : read(node);
  };
  return value;
}

}  // namespace twin::scenario
