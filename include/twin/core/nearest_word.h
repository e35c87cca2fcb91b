#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace twin {

/// The candidate nearest to a misspelled `word`; nothing when none is near: a third of its letters
/// may be wrong. For messages that say "did you mean".
///
/// Threads: any.
[[nodiscard]] std::optional<std::string_view> Nearest(std::string_view word,
                                                      std::span<const std::string_view> candidates);

}  // namespace twin
