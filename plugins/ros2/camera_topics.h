#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "plugins/ros2/camera_messages.h"
#include "plugins/ros2/node.h"
#include "twin/core/clock.h"
#include "twin/render/image.h"
#include "twin/render/jpeg.h"
#include "twin/render/pinhole_camera.h"

namespace twin::ros2 {

struct Picture {
  render::Image image;
  render::DepthImage depth;  ///< empty unless it was wanted
  render::PinholeCamera camera;
};

/// Cameras of a simulated robot.
struct Cameras {
  std::vector<std::string> names;
  std::string frame_prefix{};  ///< of the frames' names
  double rate_hz = 10;         ///< at most
  /// Draws what the camera of this number sees now; absent: nothing is there to be seen yet. Of the
  /// cameras' thread. @throws Error when it cannot draw.
  std::function<std::optional<Picture>(std::size_t camera, bool with_depth)> paint;
};

/// The pictures of cameras, as drivers of real ones publish them, best effort: below camera/NAME
/// image_raw, image_raw/compressed (JPEG), depth/image_raw (32FC1, m) and camera_info; and the
/// frame PREFIXcamera_NAME_optical_frame (x right, y down, z ahead) in `world` on /tf. What nobody
/// reads is not drawn.
///
/// Threads: one; its own, which yields to all others.
class CameraTopics {
 public:
  /// @param now  of the clock of stamps; any thread.
  CameraTopics(Node& node, Cameras cameras, std::function<msg::Time()> now);
  ~CameraTopics();

 private:
  struct Topics;

  void Run(const std::stop_token& stop);
  void Publish(Topics& topics, const Picture& picture, const msg::Time& stamp);

  Node& node_;
  const Cameras cameras_;
  const std::function<msg::Time()> now_;
  const MonotonicClock clock_;
  std::unique_ptr<Publisher<msg::TFMessage>> tf_;
  std::vector<std::unique_ptr<Topics>> topics_;
  render::JpegEncoder encoder_;
  std::jthread thread_;
};

}  // namespace twin::ros2
