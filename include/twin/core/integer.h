#pragma once

#include <charconv>
#include <concepts>
#include <optional>
#include <string_view>
#include <system_error>

namespace twin {

/// The whole number that `text` is, in decimal digits; nullopt for any other text, a number outside
/// T, a sign + or spaces. Threads: any.
template <std::integral T>
[[nodiscard]] std::optional<T> ParseInteger(std::string_view text) noexcept {
  T number{};
  const char* const end = text.data() + text.size();
  const auto [parsed, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && parsed == end ? std::optional<T>(number) : std::nullopt;
}

}  // namespace twin
