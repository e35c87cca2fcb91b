#pragma once

#include <string_view>

namespace twin::golden {

/// What makes a page's viewers work: slider, swapping pictures, the mark in the plot of joints.
[[nodiscard]] std::string_view PageScript() noexcept;

/// What they look like.
[[nodiscard]] std::string_view PageStyle() noexcept;

}  // namespace twin::golden
