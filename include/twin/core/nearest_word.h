#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace twin {

/// The candidate nearest to a misspelled `word` for "did you mean" messages; nullopt if more than a
/// third of the letters differ.
///
/// Threads: any.
[[nodiscard]] std::optional<std::string_view> Nearest(std::string_view word,
                                                      std::span<const std::string_view> candidates);

}  // namespace twin
