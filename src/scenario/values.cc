#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/core/integer.h"
#include "twin/core/text.h"

// The single values of files: reading, writing, range and schema of each.
namespace twin::scenario {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr double kMostNumber = 1e9;

/// Calls the functions only when they are needed: a file may have a hundred thousand values.
template <typename T, typename Describe, typename Read, typename Write>
Value Single(T& value, Describe describe, Read read, Write write) {
  return {.read = [&value, read](const YamlNode& node) { value = read(node); },
          .write = [&value, write](int /*indent*/) { return std::string(write(value)); },
          .schema = [describe](Json& schema, Json& /*definitions*/) { schema = describe(); }};
}

/// The same within a range. @param range  in words: "[0, 1] rad". @param quote  around a text in
/// a message.
template <typename T, typename Describe, typename Range, typename Read, typename Write>
Value Ranged(T& value, T least, T most, Describe describe, Range range, const char* quote,
             Read read, Write write) {
  const auto is_inside = [=](T one) { return one >= least && one <= most; };  // false for NaN
  const auto with_range = [=] {
    Json schema = describe();
    schema["title"] = fmt::format("{} in {}", schema["title"].template get<std::string>(), range());
    return schema;
  };
  Value ranged = Single(value, with_range, read, write);
  ranged.read = [=, &value](const YamlNode& node) {
    value = read(node);
    if (is_inside(value)) return;
    node.Fail(fmt::format("{0}{1}{0} is out of range; it must lie in {2}", quote,
                          Shown(node.Text()), range()));
  };
  ranged.check = [=, &value](const std::string& key) {
    if (is_inside(value)) return;
    throw InputError(
        fmt::format("{}: {} is out of range; it must lie in {}", key, write(value), range()));
  };
  return ranged;
}

/// A schema without parameters.
auto Fixed(const char* title, const char* type) {
  return [=] { return Json{{"title", title}, {"type", type}}; };
}

/// Parses a scalar; an InputError of `parse` gets the node's place.
template <typename Parse>
auto Parsed(const YamlNode& node, std::string_view wanted, Parse parse) {
  const std::string text = Shown(node.Scalar(wanted));
  return node.Checked([&] { return parse(text); });
}

std::string QuantityText(double value, Dimension dimension) {
  return fmt::format("{} {}", FormatNumber(value), BaseUnit(dimension));
}

/// A number with one of the dimension's units; negative ones only where they are in range.
Json QuantitySchema(Dimension dimension, bool can_be_negative) {
  std::string units;
  for (const std::string_view unit : UnitNames(dimension)) {
    units += units.empty() ? "" : "|";
    for (const char c : unit) units += c == '^' ? "\\^" : std::string(1, c);
  }
  return {{"title", Name(dimension)},
          {"type", "string"},
          {"pattern", fmt::format(R"(^\s*{}(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*({})\s*$)",
                                  can_be_negative ? "[-+]?" : "\\+?", units)}};
}

}  // namespace

bool IsNameLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

Value Text(std::string& text) {
  return Single(text, Fixed("text", "string"), std::mem_fn(&YamlNode::Text), YamlQuoted);
}

Value Identifier(std::string& name) {
  static constexpr std::size_t kLongest = 64;
  Value value = Text(name);
  value.check = [&name](const std::string& key) {
    if (!name.empty() && name.size() <= kLongest && std::ranges::all_of(name, IsNameLetter)) return;
    throw InputError(fmt::format("{}: \"{}\" is no name; use 1 to {} letters, digits, '_' and '-'",
                                 key, name, kLongest));
  };
  value.schema = Word("name", "^[A-Za-z0-9_-]{1,64}$", {}).schema;
  return value;
}

Value Word(std::string_view title, std::string_view pattern,
           std::function<void(const YamlNode&)> read) {
  return {.read = std::move(read), .schema = [=](Json& schema, Json& /*definitions*/) {
            schema = {{"title", title}, {"type", "string"}, {"pattern", pattern}};
          }};
}

Value Bool(bool& value) {
  const auto read = [](const YamlNode& node) {
    const std::string& text = node.Scalar("true or false");
    if (text == "true" || text == "false") return text == "true";
    node.Fail(fmt::format("\"{}\" is neither true nor false", Shown(text)));
  };
  return Single(value, Fixed("true or false", "boolean"), read,
                [](bool is) { return is ? "true" : "false"; });
}

Value Number(double& value, double least, double most) {
  const auto read = [](const YamlNode& node) {
    const std::string& text = node.Scalar("a number");
    try {
      return ParseNumber(text);
    } catch (const InputError&) {
      node.Fail(fmt::format("\"{}\" is not a plain finite number", Shown(text)));
    }
  };
  const auto describe = [=] {
    return Json{{"title", "number"}, {"type", "number"}, {"minimum", least}, {"maximum", most}};
  };
  const auto range = [=] { return fmt::format("[{}, {}]", least, most); };
  return Ranged(value, least, most, describe, range, "", read, FormatNumber);
}

Value Integer(std::uint64_t& value, std::uint64_t least, std::uint64_t most) {
  const auto range = [=] { return fmt::format("[{}, {}]", least, most); };
  const auto read = [=](const YamlNode& node) {
    const std::string& text = node.Scalar("a whole number");
    const auto number = ParseInteger<std::uint64_t>(text);
    if (number && *number >= least && *number <= most) return *number;
    node.Fail(fmt::format("\"{}\" is not a whole number in {}", Shown(text), range()));
  };
  const auto write = [](std::uint64_t number) { return std::to_string(number); };
  const auto describe = [=] {
    Json schema{{"title", "whole number"}, {"type", "integer"}, {"minimum", least}};
    if (most != kNoLimit) schema["maximum"] = most;
    return schema;
  };
  if (most == kNoLimit) return Single(value, describe, read, write);
  return Ranged(value, least, most, describe, range, "\"", read, write);
}

Value Seed(std::uint64_t& seed) {
  return Integer(seed, 0, kNoLimit);
}

Value Quantity(double& value, Dimension dimension, double least, double most) {
  const auto parse = [=](const std::string& text) { return ParseQuantity(text, dimension); };
  return Ranged(
      value, least, most, [=] { return QuantitySchema(dimension, least < 0); },
      [=] { return FormatRange(least, most, dimension); }, "\"",
      [=](const YamlNode& node) { return Parsed(node, "a number with its unit", parse); },
      [=](double number) { return QuantityText(number, dimension); });
}

Value QuantityIn(double& value, Dimension dimension, const std::vector<Dimension>& all,
                 double least, double most) {
  Value quantity = Quantity(value, dimension, least, most);
  quantity.schema = [=, &value](Json& schema, Json& definitions) {
    for (const Dimension each : all) {
      Quantity(value, each, least, most).schema(schema["anyOf"].emplace_back(), definitions);
    }
  };
  return quantity;
}

Value TimeSpan(Duration& value, Duration least, Duration most) {
  return Ranged(
      value, least, most, [=] { return QuantitySchema(Dimension::kTime, least < Duration()); },
      [=] { return fmt::format("[{}, {}]", FormatDuration(least), FormatDuration(most)); }, "\"",
      [](const YamlNode& node) { return Parsed(node, "a time with its unit", ParseDuration); },
      FormatDuration);
}

Value Array(std::span<double> values, const std::function<Value(double&)>& bind,
            const std::string& wrong_count) {
  const auto read = [=](const YamlNode& node) {
    const std::vector<YamlNode> items = node.Items();
    if (items.size() != values.size()) {
      node.Fail(fmt::format(fmt::runtime(wrong_count), items.size()));
    }
    for (std::size_t i = 0; i < items.size(); ++i) bind(values[i]).read(items[i]);
  };
  const auto write = [=](int /*indent*/) {
    std::vector<std::string> items;
    for (double& value : values) items.push_back(bind(value).write(-1));
    return ListText(items, -1);
  };
  const auto check = [=](const std::string& key) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      bind(values[i]).check(fmt::format("{}[{}]", key, i + 1));
    }
  };
  return {.read = read, .write = write, .check = check, .schema = [=](Json& schema, Json& defs) {
            ListSchema(schema, defs, bind(values[0]));
            schema["title"] = fmt::format("list of {}, each: {}", values.size(),
                                          schema["items"]["title"].get<std::string>());
            schema["minItems"] = schema["maxItems"] = values.size();
          }};
}

Value Vector(std::span<double, 3> value, Dimension dimension, double least, double most) {
  const auto bind = [=](double& part) { return Quantity(part, dimension, least, most); };
  return Array(value, bind, "has {} values; it needs 3: x, y, z");
}

Value Axes(std::span<double, 3> value, Dimension dimension, double least, double most) {
  const auto one = std::make_shared<double>(0);
  Value for_all = Quantity(*one, dimension, least, most);
  for_all.read = [=, read = for_all.read](const YamlNode& node) {
    read(node);
    std::ranges::fill(value, *one);
  };
  return Either(for_all, Vector(value, dimension, least, most), [] { return false; });
}

Value JointNumbers(JointVector& value, const std::shared_ptr<double>& factor) {
  const auto bind = [](double& number) { return Number(number, -kMostNumber, kMostNumber); };
  Value numbers = Array(value, bind, "has {} values; it needs 7, one per joint");
  numbers.read = [&value, factor, read = numbers.read](const YamlNode& node) {
    read(node);
    for (double& number : value) number *= *factor;
  };
  return numbers;
}

Value Unit(double& factor, Dimension dimension) {
  const auto parse = [=](const std::string& text) { return UnitFactor(text, dimension); };
  return Single(
      factor,
      [=] {
        return Json{{"title", "unit"}, {"enum", UnitNames(dimension)}};
      },
      [=](const YamlNode& node) { return Parsed(node, "a text", parse); },
      [=](double /*factor*/) { return BaseUnit(dimension); });
}

Value Joints(JointVector& value, Dimension dimension) {
  Value joints = Section([&value, dimension](Map& map) {
    const auto factor = std::make_shared<double>(1);
    map.Require("unit", Unit(*factor, dimension));
    map.Require("values", JointNumbers(value, factor));
  });
  joints.schema = [dimension, describe = joints.schema](Json& schema, Json& definitions) {
    describe(schema, definitions);
    schema["title"] = fmt::format("{{unit: {}, values: [7 numbers]}}", BaseUnit(dimension));
  };
  return joints;
}

Value UnitAndValue(double& value, Dimension dimension, double least, double most) {
  return Section([=, &value](Map& map) {
    const auto factor = std::make_shared<double>(1);
    map.Require("unit", Unit(*factor, dimension));
    map.Require("value", Number(value, -kMostNumber, kMostNumber))
        .Then([=, &value](const YamlNode& node) {
          value *= *factor;
          if (value >= least && value <= most) return;
          node.Fail(fmt::format("{} is out of range; it must lie in {}", Shown(node.Text()),
                                FormatRange(least, most, dimension)));
        });
  });
}

Value NoValues() {
  const auto read = [](const YamlNode& node) {
    if (!node.IsEmpty()) node.Fail("takes no values; write {}");
  };
  return {.read = read,
          .write = [](int /*indent*/) { return std::string("{}"); },
          .schema =
              [](Json& schema, Json& /*definitions*/) {
                schema = {{"title", "{}"}, {"type", "object"}, {"maxProperties", 0}};
              }};
}

Value Anything() {
  return {.read = [](const YamlNode& /*node*/) {}};
}

Value OneOfNames(std::vector<std::string_view> names, const std::function<void(std::size_t)>& set,
                 const std::function<std::size_t()>& get) {
  const std::string title = fmt::format("{}", fmt::join(names, ", "));
  return {.read = [names, set](const YamlNode& node) { set(node.Choice(names)); },
          .write = [names, get](int /*indent*/) { return std::string(names[get()]); },
          .schema =
              [names, title](Json& schema, Json& /*definitions*/) {
                schema = {{"title", title}, {"enum", names}};
              }};
}

}  // namespace twin::scenario
