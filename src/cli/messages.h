#pragma once

#include <memory>
#include <string>
#include <thread>

namespace twin::cli {

/// Lines on standard output from a program that must go on, whether anybody reads them or not: a
/// thread of their own writes them. At most 64 KiB wait; what comes then is dropped, and where
/// there is room again a line says how many are missing.
///
/// Threads: Put() any; the rest one, while nothing else writes to standard output.
class Messages {
 public:
  Messages();
  /// Writes what waits, as long as somebody reads: a reader that takes nothing for 200 ms is not
  /// waited for, and the rest is lost with the program.
  ~Messages();
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;

  /// Never waits for a reader. @param text  whole lines.
  void Put(std::string text);

 private:
  class Queue;

  /// Shared with the thread: one that is stuck in the system's write cannot be ended and outlives
  /// this, until the program ends.
  std::shared_ptr<Queue> queue_;
  std::thread writer_;
};

}  // namespace twin::cli
