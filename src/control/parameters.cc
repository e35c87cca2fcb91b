#include "twin/control/parameters.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin::control {
namespace {

/// @returns a value for a message: cut if too long, without control characters.
std::string Shown(std::string_view text) {
  constexpr std::size_t kMost = 60;
  std::string shown(text.substr(0, kMost));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return shown + (text.size() > kMost ? "..." : "");
}

std::string DidYouMean(std::string_view word, const std::vector<std::string_view>& candidates) {
  const auto nearest = Nearest(word, candidates);
  return nearest ? fmt::format("did you mean \"{}\"? ", *nearest) : std::string();
}

bool IsBelow(std::string_view key, std::string_view root) {
  return key.size() > root.size() && key.starts_with(root) && key[root.size()] == '.';
}

}  // namespace

ParameterReader::ParameterReader(const Parameters& parameters, std::string path)
    : parameters_(parameters), path_(std::move(path)) {}

bool ParameterReader::Has(std::string_view key) const {
  return std::ranges::any_of(
      parameters_, [&](const Parameter& p) { return p.key == key || IsBelow(p.key, key); });
}

Parameters ParameterReader::Below(std::string_view key) {
  Parameters below;
  for (const Parameter& parameter : parameters_) {
    if (!IsBelow(parameter.key, key)) continue;
    static_cast<void>(Find(parameter.key));
    below.push_back(parameter);
    below.back().key.erase(0, key.size() + 1);
  }
  return below;
}

const Parameter* ParameterReader::Find(std::string_view key) {
  if (std::ranges::find(asked_, key) == asked_.end()) asked_.emplace_back(key);
  const auto found = std::ranges::find(parameters_, key, &Parameter::key);
  return found == parameters_.end() ? nullptr : &*found;
}

void ParameterReader::Fail(const Parameter& parameter, std::string_view what) const {
  const std::string where = parameter.where.empty() ? "" : parameter.where + ": ";
  throw InputError(fmt::format("{}{}.{}: {}", where, path_, parameter.key, what));
}

void ParameterReader::Refuse(std::string_view key, std::string_view why) const {
  const auto found = std::ranges::find_if(
      parameters_, [&](const Parameter& p) { return p.key == key || IsBelow(p.key, key); });
  if (found != parameters_.end()) Fail(*found, why);
  throw InputError(fmt::format("{}.{}: {}", path_, key, why));
}

std::string ParameterReader::PlaceOf(std::string_view key) const {
  const auto found = std::ranges::find_if(
      parameters_, [&](const Parameter& p) { return p.key == key || IsBelow(p.key, key); });
  const bool is_read = found != parameters_.end() && !found->where.empty();
  return fmt::format("{}{}.{}: ", is_read ? found->where + ": " : "", path_, key);
}

const std::string& ParameterReader::Scalar(const Parameter& parameter,
                                           std::string_view wanted) const {
  if (parameter.is_list) Fail(parameter, fmt::format("is a list; {} belongs here", wanted));
  return parameter.values.front();
}

double ParameterReader::NumberOf(const Parameter& parameter, std::string_view text, double least,
                                 double most) const {
  double value = 0;
  try {
    value = ParseNumber(text);
  } catch (const InputError&) {
    Fail(parameter, fmt::format("\"{}\" is not a plain finite number", Shown(text)));
  }
  if (value >= least && value <= most) return value;
  Fail(parameter,
       fmt::format("{} is out of range; it must lie in [{}, {}]", Shown(text), least, most));
}

double ParameterReader::QuantityOf(const Parameter& parameter, std::string_view text,
                                   Dimension dimension, double least, double most) const {
  double value = 0;
  try {
    value = ParseQuantity(Shown(text), dimension);
  } catch (const InputError& error) {
    Fail(parameter, error.what());
  }
  if (value >= least && value <= most) return value;
  Fail(parameter, fmt::format("\"{}\" is out of range; it must lie in {}", text,
                              FormatRange(least, most, dimension)));
}

double ParameterReader::Number(std::string_view key, double otherwise, double least, double most) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return otherwise;
  return NumberOf(*parameter, Scalar(*parameter, "a number"), least, most);
}

double ParameterReader::Quantity(std::string_view key, Dimension dimension, double otherwise,
                                 double least, double most) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return otherwise;
  return QuantityOf(*parameter, Scalar(*parameter, "a number with its unit"), dimension, least,
                    most);
}

Duration ParameterReader::Time(std::string_view key, Duration otherwise, Duration least,
                               Duration most) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return otherwise;
  const std::string& text = Scalar(*parameter, "a time with its unit");
  Duration value{};
  try {
    value = ParseDuration(Shown(text));
  } catch (const InputError& error) {
    Fail(*parameter, error.what());
  }
  if (value >= least && value <= most) return value;
  Fail(*parameter, fmt::format("\"{}\" is out of range; it must lie in [{}, {}]", text,
                               FormatDuration(least), FormatDuration(most)));
}

bool ParameterReader::Bool(std::string_view key, bool otherwise) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return otherwise;
  const std::string& text = Scalar(*parameter, "true or false");
  if (text == "true" || text == "false") return text == "true";
  Fail(*parameter, fmt::format("\"{}\" is neither true nor false", Shown(text)));
}

std::string ParameterReader::Text(std::string_view key, std::string_view otherwise) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return std::string(otherwise);
  return Scalar(*parameter, "a text");
}

std::string ParameterReader::Choice(std::string_view key, std::string_view otherwise,
                                    std::initializer_list<std::string_view> names) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return std::string(otherwise);
  const std::string& text = Scalar(*parameter, "a name");
  if (std::ranges::find(names, text) != names.end()) return text;
  Fail(*parameter, fmt::format("\"{}\" is unknown; {}accepted: {}", Shown(text),
                               DidYouMean(text, names), fmt::join(names, ", ")));
}

Vector3 ParameterReader::Vector(std::string_view key, Dimension dimension, const Vector3& otherwise,
                                double least, double most) {
  const Parameter* parameter = Find(key);
  if (parameter == nullptr) return otherwise;
  const std::size_t count = parameter->values.size();
  Vector3 vector{};
  if (parameter->is_list && count != vector.size()) {
    Fail(*parameter, fmt::format("has {} values; it needs 3: x, y, z", count));
  }
  for (std::size_t i = 0; i < vector.size(); ++i) {
    const std::string& text = parameter->values[parameter->is_list ? i : 0];
    vector[i] = QuantityOf(*parameter, text, dimension, least, most);
  }
  return vector;
}

JointVector ParameterReader::Joints(std::string_view key, Dimension dimension,
                                    const JointVector& otherwise, double least, double most) {
  JointVector joints{};
  if (const Parameter* one = Find(key)) {
    joints.fill(QuantityOf(*one, Scalar(*one, "a number with its unit"), dimension, least, most));
    return joints;
  }
  const Parameter* unit = Find(fmt::format("{}.unit", key));
  const Parameter* values = Find(fmt::format("{}.values", key));
  if (unit == nullptr && values == nullptr) return otherwise;
  if (unit == nullptr) Fail(*values, fmt::format("key \"{}.unit\" is missing beside it", key));
  if (values == nullptr) Fail(*unit, fmt::format("key \"{}.values\" is missing beside it", key));
  double factor = 1;
  try {
    factor = UnitFactor(Shown(Scalar(*unit, "a unit")), dimension);
  } catch (const InputError& error) {
    Fail(*unit, error.what());
  }
  if (!values->is_list || values->values.size() != kJoints) {
    Fail(*values,
         fmt::format("has {} values; it needs {}, one per joint", values->values.size(), kJoints));
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    joints[i] = NumberOf(*values, values->values[i], least / factor, most / factor) * factor;
  }
  return joints;
}

void ParameterReader::RefuseUnread() const {
  const std::vector<std::string_view> asked(asked_.begin(), asked_.end());
  for (const Parameter& parameter : parameters_) {
    if (std::ranges::find(asked_, parameter.key) != asked_.end()) continue;
    if (asked.empty()) Fail(parameter, "no parameters are taken here; leave them out");
    Fail(parameter, fmt::format("unknown; {}accepted: {}", DidYouMean(parameter.key, asked),
                                fmt::join(asked, ", ")));
  }
}

}  // namespace twin::control
