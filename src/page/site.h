#pragma once

#include <span>
#include <string_view>

namespace twin::page {

/// A file of the operator's page, compiled into the program.
struct SiteFile {
  std::string_view path;  ///< in requests: "/page.js"
  std::string_view type;  ///< MIME type
  std::string_view text;
};

/// All files, generated from src/page/site. The first is the page.
[[nodiscard]] std::span<const SiteFile> Site() noexcept;

}  // namespace twin::page
