#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "twin/render/clip.h"

namespace twin::render {

/// Draws every n-th frame of a clip on a thread of its own, one ahead of what is taken.
///
/// Threads: constructed, taken from and destroyed by one thread.
class FrameWorker {
 public:
  /// Draws the frames first, first + stride, ... of `frames`, which must outlive this.
  FrameWorker(const ClipFrames& frames, std::size_t first, std::size_t stride);

  /// @returns the next of its frames; waits for it. @pre there is one.
  /// @throws what the drawer throws.
  [[nodiscard]] Image Take();

 private:
  void Run(const std::stop_token& stop);
  /// @returns false when the worker was told to stop.
  bool Put(Image image, const std::stop_token& stop);

  const ClipFrames& frames_;
  std::size_t first_;
  std::size_t stride_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Image> ready_;  // guarded by mutex_
  std::exception_ptr error_;    // guarded by mutex_
  std::jthread thread_;         // last: it stops before the rest goes
};

}  // namespace twin::render
