#pragma once

#include <span>
#include <string_view>

namespace twin::page {

/// A file of the operator's page, within the program.
struct SiteFile {
  std::string_view path;  ///< as it is asked for: "/page.js"
  std::string_view type;  ///< as HTTP names it
  std::string_view text;
};

/// All of them; src/page/site holds what they are made of. The first is the page.
[[nodiscard]] std::span<const SiteFile> Site() noexcept;

}  // namespace twin::page
