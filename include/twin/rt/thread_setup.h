#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace twin::rt {

/// How a thread of the 1 kHz path is to run.
struct ThreadSettings {
  std::string name{};     ///< shown by tools, at most 15 letters
  int fifo_priority = 0;  ///< SCHED_FIFO, 1 to 99; 0: the ordinary scheduler
  /// Of the ordinary scheduler, in [0, 19]: the more, the more it leaves to others. Threads that
  /// it starts are the same.
  int nice = 0;
  std::optional<int> cpu{};    ///< the only processor it may run on; absent: any
  bool lock_memory = true;     ///< mlockall of present and future pages of the whole process
  std::size_t stack_kb = 256;  ///< of its stack, touched in advance
};

/// Applies `settings` to the calling thread: name, scheduler, processor, memory lock, touched
/// stack. What this machine or user does not permit is left out: real time then works less well,
/// not at all wrongly.
/// @returns one line of text per thing that was not permitted, saying what follows and the cure;
/// empty when all was.
/// @throws InputError when a priority or a processor is none of this machine's.
[[nodiscard]] std::vector<std::string> SetUpThisThread(const ThreadSettings& settings);

/// A thread that has been set up.
struct StartedThread {
  std::jthread thread;
  std::vector<std::string> notices;  ///< as SetUpThisThread
};

/// Starts a thread, sets it up and returns then; it goes on with `run`.
/// @throws what SetUpThisThread threw on it; the thread has then ended without `run`.
[[nodiscard]] StartedThread StartThread(const ThreadSettings& settings,
                                        std::function<void(const std::stop_token&)> run);

}  // namespace twin::rt
