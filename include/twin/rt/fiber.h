#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>

namespace twin::rt {

/// A function with a stack of its own, on its owner's thread: it runs when the owner resumes it,
/// and gives the thread back by Yield(). So functions that wait in loops take turns in an order
/// that is theirs alone, which no scheduler of threads could promise.
///
///     Resume() -> the function -> Yield() -> back in Resume()'s caller -> Resume() -> ...
///
/// Threads: one, all its life. Resume() and Yield() allocate nothing; a switch takes less than a
/// microsecond. A fiber that has begun must end before it is destroyed (checked).
class Fiber {
 public:
  /// @param body  begins with the first Resume(). What it throws leaves by that Resume() in which
  /// it ended.
  explicit Fiber(std::function<void()> body, std::size_t stack_bytes = std::size_t{8} << 20);
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Runs the function until it yields or ends. @pre !ended(), and not from within it.
  /// @throws what the function throws.
  void Resume();
  [[nodiscard]] bool ended() const noexcept;

  /// In a fiber's function: back to the caller of Resume(). @pre a fiber runs on this thread.
  static void Yield() noexcept;

  struct State;  ///< of the implementation

 private:
  std::unique_ptr<State> state_;
};

/// Resumes each in turn, in their order, until all have ended. @throws as Fiber::Resume.
void ResumeInTurn(std::deque<Fiber>& fibers);

}  // namespace twin::rt
