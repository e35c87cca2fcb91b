#pragma once

#include <span>
#include <string_view>

namespace twin::report {

/// A file of src/report/templates, compiled into the program.
struct TemplateFile {
  std::string_view name;  ///< path in this folder: "style.gp", "experiment/noise.html"
  std::string_view text;
};

/// All files.
[[nodiscard]] std::span<const TemplateFile> TemplateFiles() noexcept;

/// The text of a file. @pre the file exists.
[[nodiscard]] std::string_view TemplateText(std::string_view name);

}  // namespace twin::report
