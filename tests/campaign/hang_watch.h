#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>

#include "twin/core/clock.h"
#include "twin/core/time.h"

namespace twin::campaign {

/// Notices worlds that do not end, by the wall clock: nothing else passes while one hangs.
///
/// Threads: any.
class HangWatch {
 public:
  /// @param patience  for each world; zero: without end.
  /// @param give_up  called with a world's seed, on a thread of its own, once it has taken longer.
  HangWatch(Duration patience, std::function<void(std::uint64_t seed)> give_up);

  /// A world that runs, from construction to destruction.
  class World {
   public:
    World(HangWatch& watch, std::uint64_t seed);
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    ~World();

   private:
    HangWatch& watch_;
    const std::uint64_t seed_;
  };

 private:
  void Run(const std::stop_token& stop);

  const MonotonicClock clock_;
  const Duration patience_;
  const std::function<void(std::uint64_t)> give_up_;
  std::mutex mutex_;
  std::condition_variable_any stopped_;
  std::map<std::uint64_t, Time> begun_;  ///< by seed, guarded by mutex_
  std::jthread thread_;                  // last, so that it stops before the rest is destroyed
};

/// From now on a crash of the program, or exit(), by a user's controller for example, says on
/// stderr which HangWatch::World was running on its thread.
void TellCrashes();

}  // namespace twin::campaign
