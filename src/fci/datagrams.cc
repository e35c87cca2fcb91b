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
template <Protocol kProtocol, typename Mode>
constexpr std::uint8_t LastMode() {
  if constexpr (std::is_same_v<Mode, RobotMode>) {
    return static_cast<std::uint8_t>(RobotMode::kAutomaticErrorRecovery);
  } else if constexpr (std::is_same_v<Mode, MotionGeneratorMode>) {
    return static_cast<std::uint8_t>(kProtocol == Protocol::k5
                                         ? MotionGeneratorMode::kCartesianVelocity
                                         : MotionGeneratorMode::kNone);
  } else if constexpr (std::is_same_v<Mode, PumpStatus>) {
    return static_cast<std::uint8_t>(PumpStatus::kRed);
  } else {
    static_assert(std::is_same_v<Mode, ControllerMode>);
    return static_cast<std::uint8_t>(ControllerMode::kOther);
  }
}

/// Where protocol 10 has a command's torque_command_finished.
constexpr std::size_t kTorqueFinishedAt = kCommandBytes;
static_assert(kTorqueFinishedAt + 1 == kCommand10Bytes);

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

/// @tparam kHalved  numbers are in single precision.
template <Protocol kProtocol, NotFinite kNotFinite, bool kHalved, typename T>
DatagramFault FaultIn(const std::byte* at) noexcept {
  if constexpr (std::is_enum_v<T>) {
    if (static_cast<std::uint8_t>(*at) > LastMode<kProtocol, T>()) return DatagramFault::kEnum;
  } else if constexpr (wire::kIsFlags<T>) {
    if (!wire::AreFlags({at, wire::kBytes<T>})) return DatagramFault::kBool;
  } else if constexpr (kNotFinite == NotFinite::kRefused) {
    static_assert(!kHalved, "commands are in double precision");
    T value;
    wire::Take(at, value);
    if (!IsFinite(value)) return DatagramFault::kNotFinite;
  }
  return DatagramFault::kNone;
}

template <Protocol kProtocol, bool kHalves, typename Struct, typename... Field>
void EncodeFields(const Struct& datagram, const std::tuple<Field...>& fields,
                  std::byte* bytes) noexcept {
  const auto put = [&]<typename One>(const One& field) {
    const std::size_t offset = field.OffsetIn(kProtocol);
    if (offset == kAbsent) return;
    if constexpr (kHalves && wire::kIsReal<typename One::Type>) {
      wire::PutSingle(bytes + offset, datagram.*(field.member));
    } else {
      wire::Put(bytes + offset, datagram.*(field.member));
    }
  };
  std::apply([&](const auto&... field) { (put(field), ...); }, fields);
}

/// Checks all fields before it writes the first, so that a bad datagram changes nothing.
template <Protocol kProtocol, bool kHalves, NotFinite kNotFinite, typename Struct,
          typename... Field>
DatagramFault DecodeFields(std::span<const std::byte> bytes, std::size_t size,
                           const std::tuple<Field...>& fields, Struct& datagram) noexcept {
  if (bytes.size() < size) return DatagramFault::kSize;
  DatagramFault fault = DatagramFault::kNone;
  const auto is_good = [&]<typename One>(const One& field) {
    using Type = typename One::Type;
    constexpr bool kHalved = kHalves && wire::kIsReal<Type>;
    const std::size_t offset = field.OffsetIn(kProtocol);
    if (offset == kAbsent) return true;
    fault = FaultIn<kProtocol, kNotFinite, kHalved, Type>(bytes.data() + offset);
    return fault == DatagramFault::kNone;
  };
  std::apply([&](const auto&... field) { static_cast<void>((is_good(field) && ...)); }, fields);
  if (fault != DatagramFault::kNone) return fault;
  const auto take = [&]<typename One>(const One& field) {
    const std::size_t offset = field.OffsetIn(kProtocol);
    if (offset == kAbsent) return;
    if constexpr (kHalves && wire::kIsReal<typename One::Type>) {
      wire::TakeSingle(bytes.data() + offset, datagram.*(field.member));
    } else {
      wire::Take(bytes.data() + offset, datagram.*(field.member));
    }
  };
  std::apply([&](const auto&... field) { (take(field), ...); }, fields);
  return DatagramFault::kNone;
}

}  // namespace

void Encode(const RobotState& state, StateBytes& bytes) noexcept {
  EncodeFields<Protocol::k5, false>(state, kStateFields, bytes.data());
}

void Encode(const RobotCommand& command, CommandBytes& bytes) noexcept {
  EncodeFields<Protocol::k5, false>(command, kCommandFields, bytes.data());
}

void Encode(const HandState& state, HandStateBytes& bytes) noexcept {
  EncodeFields<Protocol::k5, false>(state, kHandStateFields, bytes.data());
}

std::span<const std::byte> Encode(Protocol protocol, const RobotState& state,
                                  StateBytes& bytes) noexcept {
  if (protocol == Protocol::k5) {
    Encode(state, bytes);
  } else {
    EncodeFields<Protocol::k10, true>(state, kStateFields, bytes.data());
  }
  return std::span(bytes).first(StateBytesOf(protocol));
}

std::span<const std::byte> Encode(Protocol protocol, const RobotCommand& command,
                                  AnyCommandBytes& bytes) noexcept {
  EncodeFields<Protocol::k5, false>(command, kCommandFields, bytes.data());
  wire::Put(bytes.data() + kTorqueFinishedAt, command.motion_generation_finished);
  return std::span(bytes).first(CommandBytesOf(protocol));
}

void Encode(const VacuumState& state, VacuumStateBytes& bytes) noexcept {
  EncodeFields<Protocol::k5, false>(state, kVacuumStateFields, bytes.data());
}

DatagramFault Decode(std::span<const std::byte> bytes, RobotState& state) noexcept {
  return DecodeFields<Protocol::k5, false, NotFinite::kTaken>(bytes, kStateBytes, kStateFields,
                                                              state);
}

DatagramFault Decode(std::span<const std::byte> bytes, RobotCommand& command) noexcept {
  return DecodeFields<Protocol::k5, false, NotFinite::kRefused>(bytes, kCommandBytes,
                                                                kCommandFields, command);
}

DatagramFault Decode(std::span<const std::byte> bytes, HandState& state) noexcept {
  return DecodeFields<Protocol::k5, false, NotFinite::kTaken>(bytes, kHandStateBytes,
                                                              kHandStateFields, state);
}

DatagramFault Decode(Protocol protocol, std::span<const std::byte> bytes,
                     RobotState& state) noexcept {
  if (protocol == Protocol::k5) return Decode(bytes, state);
  return DecodeFields<Protocol::k10, true, NotFinite::kTaken>(bytes, kState10Bytes, kStateFields,
                                                              state);
}

DatagramFault Decode(Protocol protocol, std::span<const std::byte> bytes,
                     RobotCommand& command) noexcept {
  if (protocol == Protocol::k5) return Decode(bytes, command);
  if (bytes.size() < kCommand10Bytes) return DatagramFault::kSize;
  if (!wire::AreFlags(bytes.subspan(kTorqueFinishedAt, 1))) return DatagramFault::kBool;
  const DatagramFault fault = Decode(bytes, command);
  const bool ends = bytes[kTorqueFinishedAt] == std::byte{1};
  if (fault == DatagramFault::kNone && ends) command.motion_generation_finished = true;
  return fault;
}

DatagramFault Decode(std::span<const std::byte> bytes, VacuumState& state) noexcept {
  return DecodeFields<Protocol::k5, false, NotFinite::kTaken>(bytes, kVacuumStateBytes,
                                                              kVacuumStateFields, state);
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
