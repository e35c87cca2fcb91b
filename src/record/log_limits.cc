#include "record/log_limits.h"

#include <array>
#include <charconv>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record {
namespace {

/// Calls `field(key, numbers)` for each of the limits' fields.
template <class Limits, class Field>
void ForEachField(Limits& limits, Field&& field) {
  auto& joints = limits.joints;
  field("joint.q_min", std::span(joints.q_min));
  field("joint.q_max", std::span(joints.q_max));
  field("joint.dq_max", std::span(joints.dq_max));
  field("joint.ddq_max", std::span(joints.ddq_max));
  field("joint.dddq_max", std::span(joints.dddq_max));
  field("joint.tau_max", std::span(joints.tau_max));
  field("joint.dtau_max", std::span(joints.dtau_max));
  const auto bound = [&field](const std::string& name, auto& of) {
    field("cartesian." + name + ".dp_max", std::span(&of.dp_max, 1));
    field("cartesian." + name + ".ddp_max", std::span(&of.ddp_max, 1));
    field("cartesian." + name + ".dddp_max", std::span(&of.dddp_max, 1));
  };
  bound("translation", limits.cartesian.translation);
  bound("rotation", limits.cartesian.rotation);
  bound("elbow", limits.cartesian.elbow);
}

/// Parses exactly as many numbers as `numbers` holds, separated by single spaces. @returns success.
bool Parse(std::string_view text, std::span<double> numbers) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0 && (at == end || *at++ != ' ')) return false;
    const auto [parsed, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc()) return false;
    at = parsed;
  }
  return at == end;
}

}  // namespace

Metadata LimitsToMetadata(const RunLimits& limits) {
  Metadata entries;
  ForEachField(limits, [&entries](const std::string& key, std::span<const double> numbers) {
    entries[key] = fmt::format("{}", fmt::join(numbers, " "));
  });
  return entries;
}

RunLimits LimitsFromMetadata(const Metadata& entries) {
  RunLimits limits;
  ForEachField(limits, [&entries](const std::string& key, std::span<double> numbers) {
    const auto entry = entries.find(key);
    if (entry == entries.end()) {
      throw InputError(fmt::format("limit {} is missing in the metadata", key));
    }
    if (!Parse(entry->second, numbers)) {
      throw InputError(fmt::format("limit {} in the metadata is '{}'; it must be {} numbers", key,
                                   entry->second, numbers.size()));
    }
  });
  limits.joints.Validate();
  limits.cartesian.Validate();
  return limits;
}

}  // namespace twin::record
