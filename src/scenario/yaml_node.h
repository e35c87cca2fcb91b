#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "twin/core/joint_vector.h"
#include "twin/core/quantity.h"

namespace twin::scenario {

class YamlMap;

/// A value in a YAML file that knows where it stands. A thin reader over YAML::Node: every reading
/// function throws InputError "<file>:<line>: <key>: <what is wrong, what is accepted>". No
/// exception of yaml-cpp leaves it.
///
/// Threads: one thread.
class YamlNode {
 public:
  /// @param text  a whole document. @param file  its name in messages.
  [[nodiscard]] static YamlNode Parse(const std::string& text, const std::string& file);

  /// Reads and parses a file. @throws InputError also when it cannot be read.
  [[nodiscard]] static YamlNode ParseFile(const std::string& path);

  /// The value as a map with no other keys than `allowed`, none of them twice.
  [[nodiscard]] YamlMap Map(std::initializer_list<std::string_view> allowed) const;
  /// The value as a map with exactly one of these keys. @returns the key and its value.
  [[nodiscard]] std::pair<std::string, YamlNode> OneOf(
      std::initializer_list<std::string_view> keys) const;
  /// The value as a map of whatever keys, none of them twice, at least one.
  [[nodiscard]] std::vector<std::pair<std::string, YamlNode>> Entries() const;
  /// The values of a sequence.
  [[nodiscard]] std::vector<YamlNode> Items() const;

  [[nodiscard]] std::string Text() const;
  [[nodiscard]] bool Bool() const;
  /// A plain finite number in [least, most].
  [[nodiscard]] double Number(double least, double most) const;
  /// A whole number in [least, most].
  [[nodiscard]] std::uint64_t Integer(std::uint64_t least, std::uint64_t most) const;
  /// A number with a unit, in the dimension's base unit, in [least, most] (also base unit).
  [[nodiscard]] double Quantity(Dimension dimension, double least, double most) const;
  /// [x, y, z], each a number with a unit, in the dimension's base unit, in [least, most].
  [[nodiscard]] Vector3 Vector(Dimension dimension, double least, double most) const;
  /// A time in [least, most].
  [[nodiscard]] Duration Time(Duration least, Duration most) const;
  /// {unit: rad/s, value: 2.5}, in the dimension's base unit, in [least, most] (also base unit).
  [[nodiscard]] double UnitAndValue(Dimension dimension, double least, double most) const;
  /// {unit: rad, values: [7 numbers]}, in the dimension's base unit.
  [[nodiscard]] JointVector JointQuantity(Dimension dimension) const;
  /// [7 plain numbers] times `factor`.
  [[nodiscard]] JointVector JointNumbers(double factor) const;
  /// One of the given names. @returns its value.
  template <typename Enum>
  [[nodiscard]] Enum Choice(std::span<const std::pair<std::string_view, Enum>> names) const {
    std::vector<std::string_view> accepted;
    const std::string text = Text();
    for (const auto& [name, value] : names) {
      if (name == text) return value;
      accepted.push_back(name);
    }
    FailChoice(text, accepted);
  }

  [[nodiscard]] bool IsMap() const { return node_.IsMap(); }
  /// Whether it is a map with this key.
  [[nodiscard]] bool Has(std::string_view key) const;
  [[nodiscard]] bool IsScalar() const { return node_.IsScalar(); }
  /// Nothing, or a map or list of nothing.
  [[nodiscard]] bool IsEmpty() const { return !node_.IsScalar() && node_.size() == 0; }

  /// "<file>:<line>".
  [[nodiscard]] std::string Where() const;
  /// Throws InputError with file, line and key in front of `what`.
  [[noreturn]] void Fail(std::string_view what) const;

 private:
  friend class YamlMap;
  YamlNode(const YAML::Node& node, std::shared_ptr<const std::string> file, std::string key,
           int line);
  [[nodiscard]] YamlNode Entry(const YAML::Node& key, const YAML::Node& value) const;
  [[nodiscard]] double Factor(Dimension dimension) const;
  [[nodiscard]] const std::string& Scalar(std::string_view wanted) const;
  [[noreturn]] void FailChoice(std::string_view given,
                               std::span<const std::string_view> accepted) const;

  YAML::Node node_;
  std::shared_ptr<const std::string> file_;
  std::string key_;  ///< from the root, dotted; empty at the root
  int line_;         ///< from 1
};

/// A map whose keys have been checked.
class YamlMap {
 public:
  /// @pre key is one of the allowed ones.
  [[nodiscard]] std::optional<YamlNode> Find(std::string_view key) const;
  /// @throws InputError when the key is missing.
  [[nodiscard]] YamlNode Require(std::string_view key) const;
  [[nodiscard]] const YamlNode& node() const { return node_; }

 private:
  friend class YamlNode;
  explicit YamlMap(YamlNode node) : node_(std::move(node)) {}
  YamlNode node_;
  std::vector<std::pair<std::string, YamlNode>> entries_;
};

/// Calls `use` with the value of a key that may be absent.
template <typename Use>
void IfGiven(const YamlMap& map, std::string_view key, Use use) {
  if (const auto node = map.Find(key)) use(*node);
}

/// Reads a file of at most 4 MiB. @throws InputError when it is no regular file, is larger, or
/// cannot be read.
[[nodiscard]] std::string ReadTextFile(const std::string& path);

}  // namespace twin::scenario
