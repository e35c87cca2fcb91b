#pragma once

#include <string_view>

namespace twin::run {

/// Thrown when the user asked to end while no motion runs.
class Interrupted {};

/// Where a run says what it does, and learns that the user wants it to end. A program gives its
/// terminal.
///
/// Threads: one; Interrupt() any.
class Console {
 public:
  virtual ~Console() = default;

  /// What people want to see: whole lines.
  virtual void Print(std::string_view text) = 0;
  /// What they must see: whole lines.
  virtual void Say(std::string_view text) = 0;
  /// One line, without its end: something is not as one may think, or as it should be.
  virtual void Note(std::string_view text) = 0;
  virtual void Warn(std::string_view text) = 0;
  /// How far a piece of work is. @param share  done, in [0, 1]. @param note  shown behind it.
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
