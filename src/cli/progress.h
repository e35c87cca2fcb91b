#pragma once

#include <string>
#include <string_view>

#include "twin/core/clock.h"

namespace twin::cli {

/// Shows how far a piece of work is: a bar that is redrawn on a terminal, a line about every tenth
/// otherwise.
///
/// Threads: one thread.
class Progress {
 public:
  enum class Style { kNone, kLines, kBar };

  /// @returns the style for standard output as it is.
  [[nodiscard]] static Style StyleOfStdout(bool quiet);

  /// @param what   "run", "video". @param clock  must outlive this.
  Progress(std::string what, Style style, const Clock& clock);
  /// Ends the bar's line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param share  done, in [0, 1]; more counts as all. @param note  shown behind it.
  void Show(double share, std::string_view note);
  /// Before something else is printed.
  void EndLine();
  [[nodiscard]] const std::string& what() const noexcept { return what_; }

 private:
  void DrawBar(double share, std::string_view note);

  std::string what_;
  Style style_;
  const Clock& clock_;
  int tenths_ = 0;  ///< lines printed so far
  bool drawn_ = false;
  bool complete_ = false;
  Time next_draw_{};
};

}  // namespace twin::cli
