#include "scenario/yaml_node.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/nearest_word.h"

namespace twin::scenario {
namespace {

std::string Join(std::span<const std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) {
    if (!text.empty()) text += ", ";
    text += word;
  }
  return text;
}

std::string DidYouMean(std::string_view word, std::span<const std::string_view> candidates) {
  const auto nearest = Nearest(word, candidates);
  return nearest ? fmt::format("did you mean \"{}\"? ", *nearest) : std::string();
}

/// What a value is, for people.
std::string_view Kind(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Map: return "a map";
    case YAML::NodeType::Sequence: return "a list";
    case YAML::NodeType::Scalar: return "a single value";
    default: return "empty";
  }
}

int LineOf(const YAML::Node& node, int fallback) {
  const int line = node.Mark().line;
  return line < 0 ? fallback : line + 1;
}

/// A text for a message: control characters stay out of the terminal.
std::string Printable(std::string_view text) {
  std::string shown;
  for (const char c : text) {
    shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  }
  return shown;
}

/// A scalar in a message; endless ones are cut.
std::string Shown(std::string_view text) {
  constexpr std::size_t kMost = 60;
  return Printable(text.substr(0, kMost)) + (text.size() > kMost ? "..." : "");
}

}  // namespace

std::string ReadTextFile(const std::string& path) {
  constexpr std::uintmax_t kMostBytes = 32 << 20;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError(fmt::format("{}: {}; give an existing YAML file", path,
                                 error ? error.message() : "not a file"));
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMostBytes) {
    throw InputError(fmt::format("{}: has {} bytes; at most {} are read", path, size, kMostBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (size > 0) text << in.rdbuf();
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its permissions", path));
  return text.str();
}

YamlNode::YamlNode(const YAML::Node& node, std::shared_ptr<const std::string> file, std::string key,
                   int line)
    : node_(node), file_(std::move(file)), key_(std::move(key)), line_(line) {}

YamlNode YamlNode::Parse(const std::string& text, const std::string& file) {
  auto name = std::make_shared<const std::string>(file);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
    if (documents.size() > 1) {
      throw InputError(fmt::format(
          "{}: holds {} YAML documents; one belongs in a file: remove the others (--- begins each)",
          file, documents.size()));
    }
    const int line = LineOf(root, 1);
    return YamlNode(root, std::move(name), {}, line);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: not valid YAML: {}", file,
                                 std::max(error.mark.line, 0) + 1, Printable(error.msg)));
  }
}

YamlNode YamlNode::ParseFile(const std::string& path) {
  return Parse(ReadTextFile(path), path);
}

std::string YamlNode::Where() const {
  return fmt::format("{}:{}", *file_, line_);
}

void YamlNode::Fail(std::string_view what) const {
  if (key_.empty()) throw InputError(fmt::format("{}: {}", Where(), what));
  throw InputError(fmt::format("{}: {}: {}", Where(), key_, what));
}

void YamlNode::FailChoice(std::string_view given,
                          std::span<const std::string_view> accepted) const {
  Fail(fmt::format("\"{}\" is unknown; {}accepted: {}", Shown(given), DidYouMean(given, accepted),
                   Join(accepted)));
}

YamlNode YamlNode::Entry(const YAML::Node& key, const YAML::Node& value) const {
  const int line = LineOf(key, line_);
  if (!key.IsScalar()) YamlNode(key, file_, key_, line).Fail("a key must be a plain word");
  const std::string& name = key.Scalar();
  return YamlNode(value, file_, key_.empty() ? name : key_ + "." + name, line);
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::Entries() const {
  if (!node_.IsMap() || node_.size() == 0) {
    Fail(fmt::format("is {}; a map belongs here", node_.IsMap() ? "empty" : Kind(node_)));
  }
  std::vector<std::pair<std::string, YamlNode>> entries;
  for (const auto& item : node_) {
    YamlNode entry = Entry(item.first, item.second);
    const std::string& name = item.first.Scalar();
    for (const auto& [other, node] : entries) {
      if (other == name) entry.Fail(fmt::format("given twice; first in line {}", node.line_));
    }
    entries.emplace_back(name, std::move(entry));
  }
  return entries;
}

YamlMap YamlNode::Map(std::initializer_list<std::string_view> allowed) const {
  if (!node_.IsMap()) {
    Fail(fmt::format("is {}; a map with the keys {} belongs here", Kind(node_),
                     Join({allowed.begin(), allowed.size()})));
  }
  YamlMap map(*this);
  for (const auto& item : node_) {
    YamlNode entry = Entry(item.first, item.second);
    const std::string& key = item.first.Scalar();
    if (std::ranges::find(allowed, key) == allowed.end()) {
      const std::span<const std::string_view> names(allowed.begin(), allowed.size());
      YamlNode(item.second, file_, key_, entry.line_)
          .Fail(fmt::format("unknown key \"{}\"; {}accepted: {}", Shown(key),
                            DidYouMean(key, names), Join(names)));
    }
    if (map.Find(key)) {
      entry.Fail(fmt::format("given twice; first in line {}", map.Find(key)->line_));
    }
    map.entries_.emplace_back(key, std::move(entry));
  }
  return map;
}

bool YamlNode::Has(std::string_view key) const {
  if (!node_.IsMap()) return false;
  return std::ranges::any_of(node_, [key](const auto& item) {
    return item.first.IsScalar() && item.first.Scalar() == key;
  });
}

std::pair<std::string, YamlNode> YamlNode::OneOf(
    std::initializer_list<std::string_view> keys) const {
  const YamlMap map = Map(keys);
  if (map.entries_.size() != 1) {
    Fail(fmt::format("give exactly one of {}", Join({keys.begin(), keys.size()})));
  }
  return map.entries_.front();
}

std::vector<YamlNode> YamlNode::Items() const {
  if (!node_.IsSequence()) Fail(fmt::format("is {}; a list belongs here", Kind(node_)));
  std::vector<YamlNode> items;
  for (const auto& item : node_) {
    items.push_back(
        YamlNode(item, file_, fmt::format("{}[{}]", key_, items.size() + 1), LineOf(item, line_)));
  }
  return items;
}

const std::string& YamlNode::Scalar(std::string_view wanted) const {
  if (!node_.IsScalar()) Fail(fmt::format("is {}; {} belongs here", Kind(node_), wanted));
  return node_.Scalar();
}

std::string YamlNode::Text() const {
  return Scalar("a text");
}

bool YamlNode::Bool() const {
  const std::string& text = Scalar("true or false");
  if (text == "true") return true;
  if (text == "false") return false;
  Fail(fmt::format("\"{}\" is neither true nor false", Shown(text)));
}

double YamlNode::Number(double least, double most) const {
  const std::string& text = Scalar("a number");
  double value = 0;
  try {
    value = ParseNumber(text);
  } catch (const InputError&) {
    Fail(fmt::format("\"{}\" is not a plain finite number", Shown(text)));
  }
  if (value >= least && value <= most) return value;
  Fail(fmt::format("{} is out of range; it must lie in [{}, {}]", Shown(text), least, most));
}

std::uint64_t YamlNode::Integer(std::uint64_t least, std::uint64_t most) const {
  const std::string& text = Scalar("a whole number");
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) {
    return value;
  }
  Fail(fmt::format("\"{}\" is not a whole number in [{}, {}]", Shown(text), least, most));
}

double YamlNode::Quantity(Dimension dimension, double least, double most) const {
  const std::string& text = Scalar("a number with its unit");
  double value = 0;
  try {
    value = ParseQuantity(Shown(text), dimension);
  } catch (const InputError& error) {
    Fail(error.what());
  }
  if (value >= least && value <= most) return value;
  Fail(fmt::format("\"{}\" is out of range; it must lie in {}", Shown(text),
                   FormatRange(least, most, dimension)));
}

Vector3 YamlNode::Vector(Dimension dimension, double least, double most) const {
  const std::vector<YamlNode> items = Items();
  Vector3 vector{};
  if (items.size() != vector.size()) {
    Fail(fmt::format("has {} values; it needs 3: x, y, z", items.size()));
  }
  for (std::size_t i = 0; i < vector.size(); ++i) {
    vector[i] = items[i].Quantity(dimension, least, most);
  }
  return vector;
}

Duration YamlNode::Time(Duration least, Duration most) const {
  const std::string& text = Scalar("a time with its unit");
  Duration value{};
  try {
    value = ParseDuration(Shown(text));
  } catch (const InputError& error) {
    Fail(error.what());
  }
  if (value >= least && value <= most) return value;
  Fail(fmt::format("\"{}\" is out of range; it must lie in [{}, {}]", Shown(text),
                   FormatDuration(least), FormatDuration(most)));
}

double YamlNode::Factor(Dimension dimension) const {
  const std::string name = Text();
  try {
    return UnitFactor(Shown(name), dimension);
  } catch (const InputError& error) {
    Fail(error.what());
  }
}

double YamlNode::UnitAndValue(Dimension dimension, double least, double most) const {
  const YamlMap map = Map({"unit", "value"});
  const double factor = map.Require("unit").Factor(dimension);
  const YamlNode number = map.Require("value");
  const double value = number.Number(-1e9, 1e9) * factor;
  if (value >= least && value <= most) return value;
  number.Fail(fmt::format("{} is out of range; it must lie in {}", Shown(number.Text()),
                          FormatRange(least, most, dimension)));
}

JointVector YamlNode::JointQuantity(Dimension dimension) const {
  const YamlMap map = Map({"unit", "values"});
  const double factor = map.Require("unit").Factor(dimension);
  return map.Require("values").JointNumbers(factor);
}

JointVector YamlNode::JointNumbers(double factor) const {
  const std::vector<YamlNode> items = Items();
  if (items.size() != kJoints) {
    Fail(fmt::format("has {} values; it needs {}, one per joint", items.size(), kJoints));
  }
  JointVector values{};
  for (std::size_t i = 0; i < kJoints; ++i) values[i] = items[i].Number(-1e9, 1e9) * factor;
  return values;
}

std::optional<YamlNode> YamlMap::Find(std::string_view key) const {
  for (const auto& [name, node] : entries_) {
    if (name == key) return node;
  }
  return std::nullopt;
}

YamlNode YamlMap::Require(std::string_view key) const {
  if (auto found = Find(key)) return *found;
  node_.Fail(fmt::format("key \"{}\" is missing", key));
}

}  // namespace twin::scenario
