#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "plugins/ros2/messages.h"

// Messages as bytes: XCDR1, little endian, the encoding of ROS 2. Four bytes 00 01 00 00, then the
// fields, each aligned to its size counted from there. string: u32 length with its NUL, bytes, NUL.
// vector: u32 count, elements. array: elements. bool: one byte. Source: OMG DDS-XTypes 1.3, 7.4.1.
//
// Threads: any, one per object.
namespace twin::ros2 {

static_assert(std::endian::native == std::endian::little);

inline constexpr std::size_t kEncapsulationBytes = 4;
/// Longest message that is read.
inline constexpr std::size_t kMostMessageBytes = std::size_t{16} << 20;

namespace detail {
/// Accepts all fields of a message.
struct AnyVisitor {
  void operator()(std::string_view, auto&) const {}
};
}  // namespace detail

template <typename T>
concept Number = std::is_arithmetic_v<T>;
template <typename T>
concept Message = std::is_class_v<T> && requires(T& m) {
  T::Visit(m, detail::AnyVisitor());
};

/// Writes one message.
class CdrWriter {
 public:
  CdrWriter() : bytes_{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}} {}

  template <typename T>
  void operator()(std::string_view /*name*/, const T& field) {
    Write(field);
  }
  void Write(const Message auto& message) {
    std::remove_cvref_t<decltype(message)>::Visit(message, *this);
  }
  void Write(Number auto value) {
    Align(sizeof(value));
    Append(&value, sizeof(value));
  }
  void Write(const std::string& text) {
    Write(static_cast<std::uint32_t>(text.size() + 1));
    Append(text.c_str(), text.size() + 1);
  }
  template <std::size_t N>
  void Write(const BoundedString<N>& text) {
    Write(text.text);
  }
  template <typename T, std::size_t N>
  void Write(const std::array<T, N>& elements) {
    for (const T& element : elements) Write(element);
  }
  template <typename T>
  void Write(const std::vector<T>& elements) {
    Write(static_cast<std::uint32_t>(elements.size()));
    if constexpr (Number<T> && !std::same_as<T, bool>) {
      if (elements.empty()) return;
      Align(sizeof(T));
      Append(elements.data(), elements.size() * sizeof(T));
    } else {
      for (const T& element : elements) Write(element);
    }
  }

  [[nodiscard]] std::vector<std::byte> Take() && { return std::move(bytes_); }

 private:
  void Align(std::size_t size) {
    const std::size_t past = (bytes_.size() - kEncapsulationBytes) % size;
    if (past != 0) bytes_.resize(bytes_.size() + size - past);
  }
  void Append(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }

  std::vector<std::byte> bytes_;
};

/// Reads one message from bytes that may be anything. Memory is bounded by a small multiple of the
/// bytes: a count is believed element by element.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> bytes) : bytes_(bytes) {
    ok_ = bytes.size() >= kEncapsulationBytes && bytes.size() <= kMostMessageBytes &&
          bytes[0] == std::byte{0} && bytes[1] == std::byte{1};
    at_ = kEncapsulationBytes;
  }

  /// Whether all that was read was there and well-formed.
  [[nodiscard]] bool ok() const noexcept { return ok_; }

  template <typename T>
  void operator()(std::string_view /*name*/, T& field) {
    Read(field);
  }
  void Read(Message auto& message) {
    if (ok_) std::remove_cvref_t<decltype(message)>::Visit(message, *this);
  }
  void Read(Number auto& value) {
    const std::size_t size = sizeof(value);
    const std::size_t past = (at_ - kEncapsulationBytes) % size;
    if (!Has(past == 0 ? size : size - past + size)) return;
    if (past != 0) at_ += size - past;
    if constexpr (std::same_as<std::remove_cvref_t<decltype(value)>, bool>) {
      ok_ = bytes_[at_] <= std::byte{1};
      value = bytes_[at_] == std::byte{1};
    } else {
      std::memcpy(&value, bytes_.data() + at_, size);
    }
    at_ += size;
  }
  void Read(std::string& text) {
    std::uint32_t length = 0;
    Read(length);
    if (!ok_ || !Has(length)) return;
    const auto* from = reinterpret_cast<const char*>(bytes_.data() + at_);
    at_ += length;
    if (length == 0) return text.clear();  // some write an empty string so
    ok_ = from[length - 1] == '\0';
    text.assign(from, length - 1);
  }
  template <std::size_t N>
  void Read(BoundedString<N>& text) {
    Read(text.text);
    ok_ = ok_ && text.text.size() <= N;
  }
  template <typename T, std::size_t N>
  void Read(std::array<T, N>& elements) {
    for (T& element : elements) Read(element);
  }
  template <typename T>
  void Read(std::vector<T>& elements) {
    std::uint32_t count = 0;
    Read(count);
    elements.clear();
    if (!ok_ || !Has(count)) return;  // an element has a byte at least
    if constexpr (Number<T>) {
      if (!Has(count * sizeof(T))) return;
      elements.reserve(count);
    }
    for (std::uint32_t i = 0; i < count && ok_; ++i) {
      // Not emplace_back() and a reference: std::vector<bool> has none.
      T element{};
      Read(element);
      elements.push_back(std::move(element));
    }
  }

 private:
  /// Whether so many bytes are left; else nothing more is read.
  bool Has(std::size_t size) noexcept {
    ok_ = ok_ && bytes_.size() - at_ >= size;
    return ok_;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;  ///< never beyond the bytes while ok_
  bool ok_ = true;
};

template <Message M>
[[nodiscard]] std::vector<std::byte> ToBytes(const M& message) {
  CdrWriter writer;
  writer.Write(message);
  return std::move(writer).Take();
}

/// nullopt for bytes that are no such message. Bytes behind it are ignored: they pad.
template <Message M>
[[nodiscard]] std::optional<M> FromBytes(std::span<const std::byte> bytes) {
  M message;
  CdrReader reader(bytes);
  reader.Read(message);
  return reader.ok() ? std::optional(std::move(message)) : std::nullopt;
}

}  // namespace twin::ros2
