#include "render/frame_worker.h"

#include <utility>

namespace twin::render {

FrameWorker::FrameWorker(const ClipFrames& frames) : frames_(frames) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Image FrameWorker::Take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ready_.has_value() || error_; });
  if (!ready_) std::rethrow_exception(error_);
  Image image = std::move(*ready_);
  ready_.reset();
  changed_.notify_all();
  return image;
}

void FrameWorker::Run(const std::stop_token& stop) {
  try {
    const DrawFrame draw = frames_.new_drawer();
    for (std::size_t i = 0; i < frames_.count; ++i) {
      if (!Put(draw(i), stop)) return;
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
    changed_.notify_all();
  }
}

bool FrameWorker::Put(Image image, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait(lock, stop, [this] { return !ready_.has_value(); })) return false;
  ready_ = std::move(image);
  changed_.notify_all();
  return true;
}

}  // namespace twin::render
