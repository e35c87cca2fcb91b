#include "scenario/yaml_node.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin::scenario {
namespace {

std::string DidYouMean(std::string_view word, std::span<const std::string_view> candidates) {
  const auto nearest = Nearest(word, candidates);
  return nearest ? fmt::format("did you mean \"{}\"? ", *nearest) : std::string();
}

/// The kind of a value, for messages.
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

}  // namespace

std::string Shown(std::string_view text) {
  constexpr std::size_t kMost = 60;
  return Printable(text.substr(0, kMost)) + (text.size() > kMost ? "..." : "");
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

std::size_t YamlNode::Choice(std::span<const std::string_view> names) const {
  const std::string text = Text();
  const auto found = std::ranges::find(names, text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  Fail(fmt::format("\"{}\" is unknown; {}accepted: {}", Shown(text), DidYouMean(text, names),
                   fmt::join(names, ", ")));
}

YamlNode YamlNode::Entry(const YAML::Node& key, const YAML::Node& value) const {
  const int line = LineOf(key, line_);
  if (!key.IsScalar()) YamlNode(key, file_, key_, line).Fail("a key must be a plain word");
  const std::string& name = key.Scalar();
  return YamlNode(value, file_, key_.empty() ? name : key_ + "." + name, line);
}

YamlNode::Members YamlNode::Entries() const {
  if (!node_.IsMap() || node_.size() == 0) {
    Fail(fmt::format("is {}; a map belongs here", node_.IsMap() ? "empty" : Kind(node_)));
  }
  return MembersOf({});
}

YamlNode::Members YamlNode::Map(std::span<const std::string_view> allowed) const {
  if (node_.IsMap()) return MembersOf(allowed);
  Fail(fmt::format("is {}; a map with the keys {} belongs here", Kind(node_),
                   fmt::join(allowed, ", ")));
}

YamlNode::Members YamlNode::MembersOf(std::span<const std::string_view> allowed) const {
  Members members;
  std::unordered_map<std::string, int> first_lines;
  for (const auto& item : node_) {
    YamlNode entry = Entry(item.first, item.second);
    const std::string& key = item.first.Scalar();
    if (!allowed.empty() && std::ranges::find(allowed, key) == allowed.end()) {
      YamlNode(item.second, file_, key_, entry.line_)
          .Fail(fmt::format("unknown key \"{}\"; {}accepted: {}", Shown(key),
                            DidYouMean(key, allowed), fmt::join(allowed, ", ")));
    }
    const auto [first, is_new] = first_lines.emplace(key, entry.line_);
    if (!is_new) entry.Fail(fmt::format("given twice; first in line {}", first->second));
    members.emplace_back(key, std::move(entry));
  }
  return members;
}

std::optional<YamlNode> YamlNode::Member(std::string_view key) const {
  if (!node_.IsMap()) return std::nullopt;
  for (const auto& item : node_) {
    if (item.first.IsScalar() && item.first.Scalar() == key) return Entry(item.first, item.second);
  }
  return std::nullopt;
}

YamlNode YamlNode::With(std::span<const std::pair<std::string, YamlNode>> more) const {
  YAML::Node all(YAML::NodeType::Map);
  for (const auto& item : node_) all.force_insert(item.first, item.second);  // keeps their lines
  for (const auto& [key, node] : more) all.force_insert(key, node.node_);
  return YamlNode(all, file_, key_, line_);
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

std::string YamlNode::FlowText() const {
  constexpr std::string_view kQuoted = "!";
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  if (node_.IsScalar() && node_.Tag() == kQuoted) out.SetStringFormat(YAML::DoubleQuoted);
  out << node_;
  std::string text = out.c_str();
  for (char& c : text) c = c == '\n' ? ' ' : c;  // where yaml-cpp breaks a long line
  return text;
}

const std::string& YamlNode::Scalar(std::string_view wanted) const {
  if (!node_.IsScalar()) Fail(fmt::format("is {}; {} belongs here", Kind(node_), wanted));
  return node_.Scalar();
}

}  // namespace twin::scenario
