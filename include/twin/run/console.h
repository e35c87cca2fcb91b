#pragma once

#include <string_view>

namespace twin::run {

/// Thrown when the user asked to end while no motion runs.
class Interrupted {};

/// Output of a run, and the user's wish to end it. A program gives its terminal.
///
/// Threads: one; Interrupt() any.
class Console {
 public:
  virtual ~Console() = default;

  /// Shows a result: whole lines. A quiet console leaves them out.
  virtual void Print(std::string_view text) = 0;
  /// Shows what users must see: whole lines.
  virtual void Say(std::string_view text) = 0;
  /// Log one line (no newline): a detail; something unexpected; something wrong.
  virtual void Debug(std::string_view text) = 0;
  virtual void Note(std::string_view text) = 0;
  virtual void Warn(std::string_view text) = 0;
  /// Shows the progress of a piece of work. @param share  done, in [0, 1]. @param note  shown
  /// behind it.
  virtual void Show(std::string_view work, double share, std::string_view note) = 0;

  /// Set when the user wants to end; what a run polls.
  [[nodiscard]] virtual const volatile bool& interrupted() const noexcept = 0;
  /// As if the user had asked for it.
  virtual void Interrupt() noexcept = 0;

  void ThrowIfInterrupted() const {
    if (interrupted()) throw Interrupted();
  }
};

}  // namespace twin::run
