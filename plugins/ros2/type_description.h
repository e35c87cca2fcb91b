#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/ros2/cdr.h"
#include "plugins/ros2/messages.h"

// Descriptions of message types, and the hashes and names by which ROS 2 nodes find and compare
// them. Source: REP 2016; type ids of type_description_interfaces/msg/FieldType.
namespace twin::ros2 {

struct Field {
  std::string name;
  int type_id = 0;
  std::size_t capacity = 0;         ///< of arrays
  std::size_t string_capacity = 0;  ///< of bounded strings
  std::string nested;               ///< name of a message's type; empty: none
};

/// Fields of a type and of all that it holds, by name.
struct TypeDescription {
  std::string name;
  std::map<std::string, std::vector<Field>> types;

  /// As ROS hashes it: JSON, keys in the order of the standard.
  [[nodiscard]] std::string ToJson() const;
  /// "RIHS01_" and 64 hexadecimal digits.
  [[nodiscard]] std::string Hash() const;
};

/// The full name of a message or service type: its kName, or of what carries an action's messages
/// the action's with a suffix.
template <typename T>
[[nodiscard]] std::string NameOf() {
  if constexpr (requires { T::kName; }) {
    return T::kName;
  } else {
    return std::string(T::Of::kName) + T::kSuffix;
  }
}

/// The name on the wire: "pkg/msg/Name" is "pkg::msg::dds_::Name_".
[[nodiscard]] std::string DdsName(std::string_view name);

namespace detail {

enum TypeId : int {
  kMessageId = 1,
  kStringId = 17,
  kBoundedStringId = 21,
  kArrayOf = 48,
  kSequenceOf = 144,
};

template <typename T>
constexpr int NumberId() {
  if constexpr (std::same_as<T, std::int8_t>) return 2;
  if constexpr (std::same_as<T, std::uint8_t>) return 3;
  if constexpr (std::same_as<T, std::int16_t>) return 4;
  if constexpr (std::same_as<T, std::uint16_t>) return 5;
  if constexpr (std::same_as<T, std::int32_t>) return 6;
  if constexpr (std::same_as<T, std::uint32_t>) return 7;
  if constexpr (std::same_as<T, std::int64_t>) return 8;
  if constexpr (std::same_as<T, std::uint64_t>) return 9;
  if constexpr (std::same_as<T, float>) return 10;
  if constexpr (std::same_as<T, double>) return 11;
  if constexpr (std::same_as<T, bool>) return 15;
}

/// Collects the types below a message.
class Describer {
 public:
  explicit Describer(TypeDescription& into) : into_(into) {}

  template <Message M>
  void Add() {
    const std::string name = NameOf<M>();
    if (into_.types.contains(name)) return;
    into_.types[name];
    std::vector<Field> fields;
    M empty;
    M::Visit(empty, [&]<typename T>(std::string_view field, const T& value) {
      Field& made = fields.emplace_back(FieldOf(value));
      made.name = field;
    });
    into_.types[name] = std::move(fields);
  }

 private:
  template <typename T>
  Field FieldOf(const T& /*value*/) {
    Field field;
    if constexpr (Message<T>) {
      field.type_id = kMessageId;
      field.nested = NameOf<T>();
      Add<T>();
    } else if constexpr (std::same_as<T, std::string>) {
      field.type_id = kStringId;
    } else {
      field.type_id = NumberId<T>();
    }
    return field;
  }
  template <std::size_t N>
  Field FieldOf(const BoundedString<N>& /*value*/) {
    return {.name = {}, .type_id = kBoundedStringId, .string_capacity = N, .nested = {}};
  }
  template <typename T, std::size_t N>
  Field FieldOf(const std::array<T, N>& /*value*/) {
    Field field = FieldOf(T{});
    field.type_id += kArrayOf;
    field.capacity = N;
    return field;
  }
  template <typename T>
  Field FieldOf(const std::vector<T>& /*value*/) {
    Field field = FieldOf(T{});
    field.type_id += kSequenceOf;
    return field;
  }

  TypeDescription& into_;
};

}  // namespace detail

template <Message M>
[[nodiscard]] TypeDescription Describe() {
  TypeDescription description{.name = NameOf<M>(), .types = {}};
  detail::Describer(description).Add<M>();
  return description;
}

}  // namespace twin::ros2
