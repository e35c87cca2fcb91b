#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "twin/core/error.h"

namespace twin::scenario {

/// A value in a YAML file that knows where it stands. A thin reader over YAML::Node: every reading
/// function throws InputError "<file>:<line>: <key>: <what is wrong, what is accepted>". No
/// exception of yaml-cpp leaves it.
///
/// Threads: one thread.
class YamlNode {
 public:
  /// @param text  a whole document. @param file  its name in messages.
  [[nodiscard]] static YamlNode Parse(const std::string& text, const std::string& file);

  /// Reads and parses a file of at most 32 MiB. @throws InputError also when it is not a regular
  /// file, is larger, or cannot be read.
  [[nodiscard]] static YamlNode ParseFile(const std::string& path);

  using Members = std::vector<std::pair<std::string, YamlNode>>;

  /// The value as a map with no other keys than `allowed`, none of them twice.
  [[nodiscard]] Members Map(std::span<const std::string_view> allowed) const;
  /// The value as a map of whatever keys, none of them twice, at least one.
  [[nodiscard]] Members Entries() const;
  /// This map with further members, where it stands. @pre IsMap()
  [[nodiscard]] YamlNode With(std::span<const std::pair<std::string, YamlNode>> more) const;
  /// The values of a sequence.
  [[nodiscard]] std::vector<YamlNode> Items() const;

  /// A single value as it is written. @param wanted  what belongs there, for the message.
  [[nodiscard]] const std::string& Scalar(std::string_view wanted) const;
  [[nodiscard]] std::string Text() const { return Scalar("a text"); }
  /// One of the given names. @returns its index.
  [[nodiscard]] std::size_t Choice(std::span<const std::string_view> names) const;

  /// The value as YAML in one line, whatever it is; a single text that was quoted stays so.
  [[nodiscard]] std::string FlowText() const;
  [[nodiscard]] bool IsMap() const { return node_.IsMap(); }
  /// The value of a key, when it is a map that has it; whatever the other keys are.
  [[nodiscard]] std::optional<YamlNode> Member(std::string_view key) const;
  /// The value itself. With YamlNode::Parse: the whole document.
  [[nodiscard]] const YAML::Node& tree() const noexcept { return node_; }
  [[nodiscard]] bool IsScalar() const { return node_.IsScalar(); }
  /// Nothing, or a map or list of nothing.
  [[nodiscard]] bool IsEmpty() const { return !node_.IsScalar() && node_.size() == 0; }

  /// "<file>:<line>".
  [[nodiscard]] std::string Where() const;
  /// Throws InputError with file, line and key in front of `what`.
  [[noreturn]] void Fail(std::string_view what) const;
  /// @returns what `check` returns; an InputError of it fails with its text behind `prefix`.
  template <typename Check>
  auto Checked(Check check, std::string_view prefix = {}) const {
    try {
      return check();
    } catch (const InputError& error) {
      Fail(std::string(prefix) + error.what());
    }
  }

 private:
  YamlNode(const YAML::Node& node, std::shared_ptr<const std::string> file, std::string key,
           int line);
  [[nodiscard]] YamlNode Entry(const YAML::Node& key, const YAML::Node& value) const;
  /// @param allowed  keys; empty: any.
  [[nodiscard]] Members MembersOf(std::span<const std::string_view> allowed) const;

  YAML::Node node_;
  std::shared_ptr<const std::string> file_;
  std::string key_;  ///< from the root, dotted; empty at the root
  int line_;         ///< from 1
};

/// A text for a message: what is endless is cut, control characters stay out of the terminal.
[[nodiscard]] std::string Shown(std::string_view text);

}  // namespace twin::scenario
