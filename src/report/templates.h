#pragma once

#include <span>
#include <string_view>

namespace twin::report {

/// A file of src/report/templates, as part of the program.
struct TemplateFile {
  std::string_view name;  ///< path there: "style.gp", "experiment/noise.html"
  std::string_view text;
};

/// All of them.
[[nodiscard]] std::span<const TemplateFile> TemplateFiles() noexcept;

/// The text of one. @pre there is one of this name.
[[nodiscard]] std::string_view TemplateText(std::string_view name);

}  // namespace twin::report
