#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenario/yaml_node.h"
#include "twin/control/parameters.h"
#include "twin/core/joint_vector.h"
#include "twin/core/quantity.h"
#include "twin/core/time.h"
#include "twin/scenario/names.h"

// One description of each key of a file, from which its reader, its writer, the check of ranges,
// the table of keys and the JSON Schema come:
//
//   void Describe(Map& map, PlantSection& plant) {
//     map.Add("mass_scale", Number(plant.mass_scale, 0.5, 2), "Factor on the mass of every link.");
//     ...
//   }
//
// A default is what a default-constructed struct holds.
namespace twin::scenario {

using Json = nlohmann::ordered_json;

/// The spelling of one variable in a file. It refers to the variable, which must outlive it.
///
/// Threads: one thread.
struct Value {
  /// Takes the variable from a node. @throws InputError naming file, line and key.
  std::function<void(const YamlNode&)> read;
  /// The variable as YAML in one line; empty: nothing is written. With an indent of 0 or more, a
  /// value in block style begins with a line break and has so many spaces before each line.
  std::function<std::string(int indent)> write = [](int /*indent*/) { return std::string(); };
  /// @param key  from the root, dotted. @throws InputError when the variable is out of range.
  std::function<void(const std::string& key)> check = [](const std::string& /*key*/) {};
  /// As JSON Schema; its `title` says kind and range in words. @param definitions  `$defs`.
  std::function<void(Json& schema, Json& definitions)> schema = [](Json&, Json&) {};
};

/// The keys of a map and their values. The reader and the writer keep the order of the calls of
/// Add.
class Map {
 public:
  using Hook = std::function<void(const YamlNode&)>;

  struct Entry {
    std::string key;
    Value value;
    std::string_view meaning;
    bool is_required = false;
    bool is_omitted = false;
    Hook then{};

    /// The writer leaves the key out, and its range is not checked.
    Entry& OmitIf(bool omitted);
    /// Runs with the key's node after the key was read.
    Entry& Then(Hook hook);
    /// Remembers name and place for errors that only a run can find.
    Entry& At(Place& place);
  };

  /// @param meaning  one sentence for the documentation; must outlive the map: a literal.
  Entry& Add(std::string key, Value value, std::string_view meaning = {});
  /// Adds a key that a file must give.
  Entry& Require(std::string key, Value value, std::string_view meaning = {});
  /// Makes all keys so far required.
  void RequireAll();
  /// A file must give exactly one of the keys so far; `other` does not count.
  void ExactlyOne(std::string_view other = {});
  /// The same in the JSON Schema only; a hook checks what a file gives.
  void DescribeOneOf(std::vector<std::string_view> keys) { one_of_ = std::move(keys); }
  /// Runs with the map's node when its keys are known, before the first value is read.
  void Before(Hook hook) { before_ = std::move(hook); }
  /// Forgets all other keys.
  void Retain(std::span<const std::string_view> keys);
  /// The reader takes these keys after the others.
  void ReadLast(std::vector<std::string_view> keys) { last_ = std::move(keys); }
  /// Refuses a key of former versions. @param what  the message: what to do.
  void Renamed(std::string_view from, std::string_view what) { renamed_.emplace_back(from, what); }
  /// Remembers the place of the map in its file.
  void Where(std::string& where) { where_ = &where; }

  [[nodiscard]] std::vector<std::string_view> Keys() const;

  // The map as the file gives it. @pre called in a hook.
  [[nodiscard]] const YamlNode& node() const { return *node_; }
  [[nodiscard]] std::optional<YamlNode> Given(std::string_view key) const;
  /// @throws InputError when the key is missing.
  [[nodiscard]] YamlNode MustBeGiven(std::string_view key) const;

  // As the functions of Value.
  void Read(const YamlNode& node);
  [[nodiscard]] std::string Write(int indent) const;
  void Check(const std::string& key) const;
  void Schema(Json& schema, Json& definitions) const;

 private:
  std::vector<Entry> entries_;
  Hook before_;
  bool is_one_of_ = false;  ///< the reader requires one_of_, too
  std::vector<std::string_view> one_of_, last_;
  std::vector<std::pair<std::string_view, std::string_view>> renamed_;
  std::string* where_ = nullptr;
  std::optional<YamlNode> node_;
  YamlNode::Members given_;
};

enum class Style : std::uint8_t {
  kFlow,   ///< {a: 1, b: 2}
  kBlock,  ///< a key, or an item, a line
  kBare,   ///< a: 1, for an item of a list that is a map with one key
};

/// A map. @param describe  adds its keys; called whenever the map is read, written, ...
[[nodiscard]] Value Section(const std::function<void(Map&)>& describe, Style style = Style::kFlow);

/// A map that Describe(Map&, T&) describes.
template <typename T>
[[nodiscard]] Value SectionOf(T& section, Style style = Style::kFlow) {
  return Section([&section](Map& map) { Describe(map, section); }, style);
}

/// Puts a value that several keys take under a name into the JSON Schema's `$defs`.
[[nodiscard]] Value Defined(const std::string& name, std::string_view meaning, Value value);

/// Adds a check of the whole value. @param validate  throws InputError that says what is wrong.
[[nodiscard]] Value Validated(Value value, const std::function<void()>& validate);

/// A value of a T that may be absent. @param bind  makes the Value of a T&.
template <typename T, typename Bind>
[[nodiscard]] Value Held(std::function<T*()> find, std::function<T&()> emplace, Bind bind) {
  return {.read = [=](const YamlNode& node) { bind(emplace()).read(node); },
          .write = [=](int indent) { return find() ? bind(*find()).write(indent) : std::string(); },
          .check =
              [=](const std::string& key) {
                if (T* held = find()) bind(*held).check(key);
              },
          .schema =
              [bind](Json& schema, Json& definitions) {
                T example{};
                bind(example).schema(schema, definitions);
              }};
}

template <typename T, typename Bind>
[[nodiscard]] Value Optional(std::optional<T>& value, Bind bind) {
  return Held<T>([&value] { return value ? &*value : nullptr; },
                 [&value]() -> T& { return value.emplace(); }, bind);
}

/// The alternative T of a variant; reading it makes the variant hold a T.
template <typename T, typename Variant, typename Bind>
[[nodiscard]] Value Alternative(Variant& variant, Bind bind) {
  return Held<T>([&variant] { return std::get_if<T>(&variant); },
                 [&variant]() -> T& { return variant.template emplace<T>(); }, bind);
}

template <typename T, typename Variant>
[[nodiscard]] Value Alternative(Variant& variant) {
  return Alternative<T>(variant, [](T& one) { return SectionOf(one); });
}

/// "[a, b]", or in block style a line for each item.
[[nodiscard]] std::string ListText(const std::vector<std::string>& items, int indent);
void ListSchema(Json& schema, Json& definitions, const Value& item);

template <typename T, typename Bind>
[[nodiscard]] Value List(std::vector<T>& list, Bind bind, Style style = Style::kFlow) {
  return {.read =
              [&list, bind](const YamlNode& node) {
                list.clear();
                for (const YamlNode& item : node.Items()) bind(list.emplace_back()).read(item);
              },
          .write =
              [&list, bind, style](int indent) {
                std::vector<std::string> items;
                items.reserve(list.size());
                for (T& item : list) items.push_back(bind(item).write(-1));
                return ListText(items, style == Style::kBlock ? indent : -1);
              },
          .check =
              [&list, bind](const std::string& key) {
                std::size_t i = 0;
                for (T& item : list) bind(item).check(key + "[" + std::to_string(++i) + "]");
              },
          .schema =
              [bind](Json& schema, Json& definitions) {
                T example{};
                ListSchema(schema, definitions, bind(example));
              }};
}

/// A list in block style of maps that Describe(Map&, T&) describes.
template <typename T>
[[nodiscard]] Value ListOf(std::vector<T>& list) {
  return List(
      list, [](T& item) { return SectionOf(item); }, Style::kBlock);
}

/// A single value, or else a map or list. @param is_scalar  says which one the writer takes.
[[nodiscard]] Value Either(const Value& scalar, const Value& other,
                           const std::function<bool()>& is_scalar);
/// A word that stands for a value of the variable, or the value itself.
[[nodiscard]] Value OrWord(std::string_view word, const std::function<bool()>& is_word,
                           const std::function<void()>& set_word, const Value& other);

/// A value of another type than its variable's. @param held  the variable converted, to which
/// `bind` binds the value. @param set  converts back.
template <typename T, typename Bind, typename Set>
[[nodiscard]] Value Converted(T held, Bind bind, Set set) {
  const auto variable = std::make_shared<T>(std::move(held));
  Value value = bind(*variable);
  value.read = [variable, read = value.read, set](const YamlNode& node) {
    read(node);
    set(*variable);
  };
  return value;
}

// Single values. A range is in the dimension's base unit.
[[nodiscard]] Value Text(std::string& text);
/// 1 to 64 letters, digits, '_' and '-'. The check requires it; the reader takes any text.
[[nodiscard]] Value Identifier(std::string& name);
[[nodiscard]] bool IsNameLetter(char c);
/// A text that `read` interprets. @param pattern  regular expression for the JSON Schema.
[[nodiscard]] Value Word(std::string_view title, std::string_view pattern,
                         std::function<void(const YamlNode&)> read);
[[nodiscard]] Value Bool(bool& value);
[[nodiscard]] Value Number(double& value, double least, double most);
[[nodiscard]] Value Integer(std::uint64_t& value, std::uint64_t least, std::uint64_t most);
template <typename T>
[[nodiscard]] Value Integer(T& value, std::uint64_t least, std::uint64_t most) {
  return Converted(
      static_cast<std::uint64_t>(value),
      [least, most](std::uint64_t& held) { return Integer(held, least, most); },
      [&value](std::uint64_t held) { value = static_cast<T>(held); });
}
/// A seed of random numbers: any whole number.
[[nodiscard]] Value Seed(std::uint64_t& seed);
[[nodiscard]] Value Quantity(double& value, Dimension dimension, double least, double most);
/// A quantity whose dimension depends on another key. @param all  all its dimensions.
[[nodiscard]] Value QuantityIn(double& value, Dimension dimension,
                               const std::vector<Dimension>& all, double least, double most);
[[nodiscard]] Value TimeSpan(Duration& value, Duration least, Duration most);
/// [x, y, z].
[[nodiscard]] Value Vector(std::span<double, 3> value, Dimension dimension, double least,
                           double most);
/// [x, y, z], or one value for all.
[[nodiscard]] Value Axes(std::span<double, 3> value, Dimension dimension, double least,
                         double most);
/// A list of fixed length. @param wrong_count  message for another length, which replaces {}.
[[nodiscard]] Value Array(std::span<double> values, const std::function<Value(double&)>& bind,
                          const std::string& wrong_count);
/// 7 plain numbers in a unit that is read before them.
[[nodiscard]] Value JointNumbers(JointVector& value, const std::shared_ptr<double>& factor);
/// A unit: its factor to the dimension's base unit.
[[nodiscard]] Value Unit(double& factor, Dimension dimension);
/// {unit: rad, values: [7 numbers]}.
[[nodiscard]] Value Joints(JointVector& value, Dimension dimension);
/// {unit: rad, value: 1}.
[[nodiscard]] Value UnitAndValue(double& value, Dimension dimension, double least, double most);
/// A map of plain values, lists of plain values, and such maps, made flat: the keys dotted. Only a
/// controller, an application or a device understands it.
[[nodiscard]] Value Parameters(control::Parameters& parameters);
/// An empty map.
[[nodiscard]] Value NoValues();
/// A value that nothing reads.
[[nodiscard]] Value Anything();

/// One of some names, by its index.
[[nodiscard]] Value OneOfNames(std::vector<std::string_view> names,
                               const std::function<void(std::size_t)>& set,
                               const std::function<std::size_t()>& get);
template <typename Enum, std::size_t N>
[[nodiscard]] Value Choice(Enum& value, const std::array<Spelling<Enum>, N>& names) {
  std::vector<std::string_view> words;
  words.reserve(N);
  for (const auto& [word, each] : names) words.push_back(word);
  return OneOfNames(
      std::move(words), [&value, &names](std::size_t i) { value = names[i].second; },
      [&value, &names] {
        std::size_t i = 0;
        while (i + 1 < N && names[i].second != value) ++i;
        return i;
      });
}

}  // namespace twin::scenario
