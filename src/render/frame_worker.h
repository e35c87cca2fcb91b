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

/// Draws the frames of a clip in order on its own thread, one ahead of Take().
///
/// Threads: constructed, taken from and destroyed by one thread.
class FrameWorker {
 public:
  /// @param frames  must outlive this object.
  explicit FrameWorker(const ClipFrames& frames);

  /// Waits for the next frame. @returns it. @pre there is one.
  /// @throws the drawer's exceptions.
  [[nodiscard]] Image Take();

 private:
  void Run(const std::stop_token& stop);
  /// @returns false if the worker was told to stop.
  bool Put(Image image, const std::stop_token& stop);

  const ClipFrames& frames_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Image> ready_;  // guarded by mutex_
  std::exception_ptr error_;    // guarded by mutex_
  std::jthread thread_;         // last, so that it stops before the other members are destroyed
};

}  // namespace twin::render
