#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenario/schema.h"
#include "twin/core/text.h"

namespace twin::scenario {
namespace {

constexpr std::size_t kMostParameters = 1000;
constexpr std::size_t kDeepest = 8;

bool IsWord(std::string_view key) {
  return !key.empty() && key.find('-') == key.npos && std::ranges::all_of(key, IsNameLetter);
}

void Flatten(const YamlNode& node, const std::string& key, std::size_t depth,
             control::Parameters& parameters) {
  if (parameters.size() >= kMostParameters) {
    node.Fail(fmt::format("more than {} parameters", kMostParameters));
  }
  if (node.IsScalar()) {
    parameters.push_back({.key = key, .values = {node.Text()}, .where = node.Where()});
  } else if (!node.IsMap()) {
    control::Parameter list{.key = key, .values = {}, .is_list = true, .where = node.Where()};
    for (const YamlNode& item : node.Items()) list.values.push_back(item.Text());
    parameters.push_back(std::move(list));
  } else {
    if (depth > kDeepest) node.Fail(fmt::format("more than {} maps in each other", kDeepest));
    for (const auto& [name, entry] : node.Entries()) {
      if (!IsWord(name)) entry.Fail("a key is a word of letters, digits and '_'");
      Flatten(entry, key.empty() ? name : fmt::format("{}.{}", key, name), depth + 1, parameters);
    }
  }
}

std::string ValueText(const control::Parameter& parameter) {
  if (!parameter.is_list) return YamlQuoted(parameter.values.front());
  std::vector<std::string> items;
  std::ranges::transform(parameter.values, std::back_inserter(items), YamlQuoted);
  return ListText(items, -1);
}

/// Those that share their first `skip` letters, as a map: neighbours with the same next word
/// belong together.
std::string MapText(std::span<const control::Parameter> parameters, std::size_t skip) {
  std::string text;
  while (!parameters.empty()) {
    const std::string_view rest = std::string_view(parameters.front().key).substr(skip);
    const std::string word(rest.substr(0, rest.find('.')));
    std::size_t count = 1;
    text += (text.empty() ? "" : ", ") + word + ": ";
    if (word.size() == rest.size()) {
      text += ValueText(parameters.front());
    } else {
      const std::string inside = word + ".";
      while (count < parameters.size() &&
             std::string_view(parameters[count].key).substr(skip).starts_with(inside)) {
        ++count;
      }
      text += MapText(parameters.first(count), skip + inside.size());
    }
    parameters = parameters.subspan(count);
  }
  return "{" + text + "}";
}

}  // namespace

Value Parameters(control::Parameters& parameters) {
  return {.read =
              [&parameters](const YamlNode& node) {
                if (!node.IsMap()) node.Fail("must be a map of parameters");
                parameters.clear();
                if (!node.IsEmpty()) Flatten(node, "", 0, parameters);
              },
          .write = [&parameters](int /*indent*/) { return MapText(parameters, 0); },
          .schema =
              [](Json& schema, Json& /*definitions*/) {
                schema = {{"title", "map of parameters"}, {"type", "object"}};
              }};
}

}  // namespace twin::scenario
