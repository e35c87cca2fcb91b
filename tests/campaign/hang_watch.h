#pragma once

#include <signal.h>

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "twin/core/clock.h"
#include "twin/core/time.h"

namespace twin::campaign {

/// Notices worlds that do not end, by the wall clock: nothing else passes while one hangs.
///
/// Threads: any.
class HangWatch {
 public:
  class World;

  /// @param patience  for each world; zero: without end.
  /// @param give_up  called with a world, on a thread of its own, once it has taken longer.
  HangWatch(Duration patience, std::function<void(const World& world)> give_up);

  /// A world that runs, from construction to destruction, on the thread that makes this.
  class World {
   public:
    /// @param name  for messages. @param keep  saves what is not in a file yet, and says where.
    World(HangWatch& watch, std::string name, std::function<std::string()> keep = {});
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    ~World();

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::string Keep() const { return keep_ ? keep_() : std::string(); }

   private:
    HangWatch& watch_;
    stack_t stack_before_{};  ///< the thread's, for signals; ASan has one
    const std::string name_;
    const std::function<std::string()> keep_;
  };

 private:
  void Run(const std::stop_token& stop);

  const MonotonicClock clock_;
  const Duration patience_;
  const std::function<void(const World&)> give_up_;
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::map<const World*, Time> begun_;  ///< guarded by mutex_
  std::jthread thread_;                 // last, so that it stops before the rest is destroyed
};

/// From now on a crash of the program, or exit(), by a user's controller for example, says on
/// stderr which HangWatch::World was running on its thread.
void TellCrashes();

}  // namespace twin::campaign
