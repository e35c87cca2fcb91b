#include "record/log_text.h"

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
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
bool ParseNumbers(std::string_view text, std::span<double> numbers) {
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
    if (!ParseNumbers(entry->second, numbers)) {
      throw InputError(fmt::format("limit {} in the metadata is '{}'; it must be {} numbers", key,
                                   entry->second, numbers.size()));
    }
  });
  limits.joints.Validate();
  limits.cartesian.Validate();
  return limits;
}

namespace {

/// Length of the well-formed character at the start of `text`; 0 if there is none.
std::size_t CharacterBytes(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  // No overlong forms, no surrogates, nothing above U+10FFFF.
  if (lead == 0xE0 && byte(1) < 0xA0) return 0;
  if (lead == 0xED && byte(1) > 0x9F) return 0;
  if (lead == 0xF0 && byte(1) < 0x90) return 0;
  if (lead == 0xF4 && byte(1) > 0x8F) return 0;
  return size;
}

}  // namespace

std::string ToUtf8(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = CharacterBytes(text);
    result += size == 0 ? std::string_view("?") : text.substr(0, size);
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return result;
}

std::string ToPrintable(std::string_view text) {
  constexpr unsigned char kC1Lead = 0xC2;  // U+0080 to U+009F are C2 80 to C2 9F
  constexpr unsigned char kC1End = 0xA0;
  std::string result = ToUtf8(text);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto byte = static_cast<unsigned char>(result[i]);
    const bool is_control = byte == 0x7F || (byte < 0x20 && byte != '\n' && byte != '\t');
    if (is_control) result[i] = '?';
    if (byte == kC1Lead && static_cast<unsigned char>(result[i + 1]) < kC1End) {
      result[i] = result[i + 1] = '?';
    }
  }
  return result;
}

}  // namespace twin::record
