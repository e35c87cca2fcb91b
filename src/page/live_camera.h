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
#include "twin/rt/latest_value.h"
#include "twin/rt/scene_record.h"

struct mjModel_;

namespace twin::page {

/// Draws the newest scene, as long as somebody waits for a picture, at most 25 times a second: 640
/// x 480, JPEG. On a thread that yields to all others (nice 10; those that Mesa starts are the
/// same), since it would take whole processors.
///
/// Threads: constructed and destroyed by one; Choose() and Want() from any. Not real-time.
class LiveCamera {
 public:
  /// A picture's bytes; or why there is none, for people. Called on the camera's thread.
  struct Calls {
    std::function<void(std::string)> picture;
    std::function<void(std::string)> failure;
  };

  /// @param model, scenes  must outlive this. The camera is the scenes' only consumer.
  /// @pre views is not empty.
  LiveCamera(const mjModel_& model, rt::LatestValue<rt::SceneRecord>& scenes,
             std::vector<NamedView> views, Calls calls);

  /// @param view  its place in the list; others have no effect.
  void Choose(std::size_t view) noexcept;
  [[nodiscard]] std::size_t chosen() const noexcept {
    return chosen_.load(std::memory_order_relaxed);
  }
  /// Whether a picture is waited for.
  void Want(bool picture) noexcept { wanted_.store(picture, std::memory_order_relaxed); }

 private:
  void Run(const std::stop_token& stop);
  void Draw(const std::stop_token& stop);

  const mjModel_& model_;
  rt::LatestValue<rt::SceneRecord>& scenes_;
  const std::vector<NamedView> views_;
  const Calls calls_;
  const MonotonicClock clock_;
  // Relaxed: each is all that is told.
  std::atomic<std::size_t> chosen_{0};
  std::atomic<bool> wanted_{false};
  std::jthread thread_;
};

}  // namespace twin::page
