#pragma once

#include <string>
#include <string_view>

#include <fmt/format.h>

#include "report/run_data.h"

namespace twin::report {

// Colours that differ for colour-blind readers and in greyscale.
inline constexpr std::string_view kReferenceColour = "#0b3c6f";  ///< dark blue: q_d and the like
inline constexpr std::string_view kMeasuredColour = "#f0a030";   ///< amber: measured quantities
inline constexpr std::string_view kLimitColour = "#c0272d";      ///< red, dashed
inline constexpr std::string_view kServedColour = "#9cc3e6";     ///< light blue
inline constexpr std::string_view kHeldColour = "#d1495b";       ///< red
inline constexpr std::string_view kQuietColour = "#e3e3e3";      ///< grey: no motion
inline constexpr std::string_view kAbortColour = "#7a2a90";      ///< violet: the error's cycle

/// Builds a gnuplot script.
class Script {
 public:
  /// Begins an SVG of `columns` by `rows` panels under one title.
  Script(int width, int height, std::string_view title, int rows, int columns);

  /// Adds a line.
  template <class... Arguments>
  void Line(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...);
    text_ += '\n';
  }

  /// Ends the drawing. @returns the whole script.
  [[nodiscard]] std::string End();

 private:
  std::string text_;
};

/// `text` as a gnuplot string: quoted, without control characters.
[[nodiscard]] std::string Quote(std::string_view text);

/// "name of the scenario: what", with the error that ended the motion and a note if the log is
/// truncated.
[[nodiscard]] std::string Title(const RunData& run, std::string_view what);

}  // namespace twin::report
