#include "twin/fci/datagrams.h"

#include <array>
#include <cmath>
#include <tuple>
#include <type_traits>

#include "fci/datagram_fields.h"
#include "fci/wire.h"

namespace twin::fci {
namespace {

/// The highest valid number of a mode.
template <typename Mode>
inline constexpr std::uint8_t kLastMode = 0;
template <>
inline constexpr auto kLastMode<RobotMode> =
    static_cast<std::uint8_t>(RobotMode::kAutomaticErrorRecovery);
template <>
inline constexpr auto kLastMode<MotionGeneratorMode> =
    static_cast<std::uint8_t>(MotionGeneratorMode::kCartesianVelocity);
template <>
inline constexpr auto kLastMode<ControllerMode> = static_cast<std::uint8_t>(ControllerMode::kOther);

/// Whether a datagram may contain NaN or infinity.
enum class NotFinite : bool { kTaken, kRefused };

template <typename T>
bool IsFinite(const T& value) noexcept {
  if constexpr (std::is_floating_point_v<T>) return std::isfinite(value);
  return true;
}
template <std::size_t N>
bool IsFinite(const std::array<double, N>& values) noexcept {
  bool all = true;
  for (const double value : values) all &= std::isfinite(value);
  return all;
}

template <typename T, NotFinite kNotFinite>
DatagramFault FaultIn(const std::byte* at) noexcept {
  if constexpr (std::is_enum_v<T>) {
    if (static_cast<std::uint8_t>(*at) > kLastMode<T>) return DatagramFault::kEnum;
  } else if constexpr (wire::kIsFlags<T>) {
    if (!wire::AreFlags({at, wire::kBytes<T>})) return DatagramFault::kBool;
  } else if constexpr (kNotFinite == NotFinite::kRefused) {
    T value;
    wire::Take(at, value);
    if (!IsFinite(value)) return DatagramFault::kNotFinite;
  }
  return DatagramFault::kNone;
}

template <typename Struct, typename Fields>
void EncodeFields(const Struct& datagram, const Fields& fields, std::byte* bytes) noexcept {
  std::apply(
      [&](const auto&... field) {
        (wire::Put(bytes + field.offset, datagram.*(field.member)), ...);
      },
      fields);
}

/// Checks all fields before it writes the first, so that a bad datagram changes nothing.
template <NotFinite kNotFinite, typename Struct, typename... Field>
DatagramFault DecodeFields(std::span<const std::byte> bytes, std::size_t size,
                           const std::tuple<Field...>& fields, Struct& datagram) noexcept {
  if (bytes.size() < size) return DatagramFault::kSize;
  DatagramFault fault = DatagramFault::kNone;
  const auto is_good = [&fault](DatagramFault found) {
    fault = found;
    return found == DatagramFault::kNone;
  };
  std::apply(
      [&](const auto&... field) {
        static_cast<void>(
            (is_good(FaultIn<typename Field::Type, kNotFinite>(bytes.data() + field.offset)) &&
             ...));
      },
      fields);
  if (fault != DatagramFault::kNone) return fault;
  std::apply(
      [&](const auto&... field) {
        (wire::Take(bytes.data() + field.offset, datagram.*(field.member)), ...);
      },
      fields);
  return DatagramFault::kNone;
}

}  // namespace

void Encode(const RobotState& state, StateBytes& bytes) noexcept {
  EncodeFields(state, kStateFields, bytes.data());
}

void Encode(const RobotCommand& command, CommandBytes& bytes) noexcept {
  EncodeFields(command, kCommandFields, bytes.data());
}

void Encode(const HandState& state, HandStateBytes& bytes) noexcept {
  EncodeFields(state, kHandStateFields, bytes.data());
}

DatagramFault Decode(std::span<const std::byte> bytes, RobotState& state) noexcept {
  return DecodeFields<NotFinite::kTaken>(bytes, kStateBytes, kStateFields, state);
}

DatagramFault Decode(std::span<const std::byte> bytes, RobotCommand& command) noexcept {
  return DecodeFields<NotFinite::kRefused>(bytes, kCommandBytes, kCommandFields, command);
}

DatagramFault Decode(std::span<const std::byte> bytes, HandState& state) noexcept {
  return DecodeFields<NotFinite::kTaken>(bytes, kHandStateBytes, kHandStateFields, state);
}

std::string_view FieldWithoutNumber(const RobotState& state) noexcept {
  std::string_view name;
  const auto is_good = [&](const auto& field) {
    const bool good = IsFinite(state.*(field.member));
    if (!good) name = field.name;
    return good;
  };
  std::apply([&](const auto&... field) { static_cast<void>((is_good(field) && ...)); },
             kStateFields);
  return name;
}

std::string_view Name(DatagramFault fault) noexcept {
  switch (fault) {
    case DatagramFault::kNone: return "none";
    case DatagramFault::kSize: return "size";
    case DatagramFault::kEnum: return "enum";
    case DatagramFault::kBool: return "bool";
    case DatagramFault::kNotFinite: return "not_finite";
  }
  return "unknown";
}

}  // namespace twin::fci
