#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "twin/core/clock.h"
#include "twin/page/live_page.h"
#include "twin/record/scene_record.h"
#include "twin/rt/latest_value.h"

struct mjModel_;

namespace twin::page {

/// Draws the newest scene while a picture is wanted, at most 25 times per second: 640 x 480, JPEG.
/// Its thread and those that Mesa starts yield to all others (nice 10), since drawing would occupy
/// whole processors.
///
/// Threads: constructed and destroyed by one; Choose() and Want() from any. Not real-time.
class LiveCamera {
 public:
  /// Receives a picture's bytes, or the reason for a failure, for users. Called on the camera's
  /// thread.
  struct Calls {
    std::function<void(std::string)> picture;
    std::function<void(std::string)> failure;
  };

  /// @param model, scenes  must outlive this object. The camera is the scenes' only consumer.
  /// @pre views is not empty.
  LiveCamera(const mjModel_& model, rt::LatestValue<record::SceneRecord>& scenes,
             std::vector<NamedView> views, Calls calls);

  /// @param view  index in the list; other values have no effect.
  void Choose(std::size_t view) noexcept;
  [[nodiscard]] std::size_t chosen() const noexcept {
    return chosen_.load(std::memory_order_relaxed);
  }
  /// Sets whether a picture is wanted.
  void Want(bool picture) noexcept { wanted_.store(picture, std::memory_order_relaxed); }

 private:
  void Run(const std::stop_token& stop);
  void Draw(const std::stop_token& stop);

  const mjModel_& model_;
  rt::LatestValue<record::SceneRecord>& scenes_;
  const std::vector<NamedView> views_;
  const Calls calls_;
  const MonotonicClock clock_;
  // Relaxed: each publishes no other data.
  std::atomic<std::size_t> chosen_{0};
  std::atomic<bool> wanted_{false};
  std::jthread thread_;
};

}  // namespace twin::page
