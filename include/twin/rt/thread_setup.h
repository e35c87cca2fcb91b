#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace twin::rt {

class FiberThread;

/// Settings of a thread of the 1 kHz path.
struct ThreadSettings {
  std::string name{};     ///< shown by tools, at most 15 letters
  int fifo_priority = 0;  ///< SCHED_FIFO, 1 to 99; 0: the ordinary scheduler
  /// For the ordinary scheduler, in [0, 19]; higher values yield more to other threads. Threads
  /// that it starts inherit it.
  int nice = 0;
  std::optional<int> cpu{};    ///< the only allowed processor; absent: any
  bool lock_memory = true;     ///< mlockall of present and future pages of the whole process
  std::size_t stack_kb = 256;  ///< stack to touch in advance
  /// The thread whose function it becomes, which has its own settings; null: it is a thread. For
  /// those that know of it (robot::ThreadedRobot).
  FiberThread* shared = nullptr;
};

/// Applies `settings` to the calling thread: name, scheduler, processor, memory lock, touched
/// stack. It skips what this machine or user does not permit; real time then degrades, but results
/// stay correct.
/// @returns one line per missing permission, with its consequence and remedy; else empty.
/// @throws InputError when a priority or a processor does not exist on this machine.
[[nodiscard]] std::vector<std::string> SetUpThisThread(const ThreadSettings& settings);

/// A thread after setup.
struct StartedThread {
  std::jthread thread;
  std::vector<std::string> notices;  ///< as from SetUpThisThread
};

/// Starts a thread and returns after its setup; the thread continues with `run`.
/// @throws what SetUpThisThread throws; the thread then ends without `run`.
[[nodiscard]] StartedThread StartThread(const ThreadSettings& settings,
                                        std::function<void(const std::stop_token&)> run);

}  // namespace twin::rt
