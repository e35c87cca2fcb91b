#pragma once

#include <string_view>

namespace twin::golden {

/// Script of a page's viewers: slider, swapping pictures, the mark in the joint plot.
[[nodiscard]] std::string_view PageScript() noexcept;

/// Their style sheet.
[[nodiscard]] std::string_view PageStyle() noexcept;

}  // namespace twin::golden
