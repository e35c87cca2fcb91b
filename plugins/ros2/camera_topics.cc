#include "plugins/ros2/camera_topics.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "plugins/ros2/conversions.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"
#include "twin/rt/thread_setup.h"

namespace twin::ros2 {
namespace {

constexpr int kQuality = 85;
constexpr Quality kSensor{.is_reliable = false, .depth = 5};
constexpr Quality kPictures{.is_reliable = false, .depth = 2, .is_large = true};

/// An ideal pinhole camera.
msg::CameraInfo InfoOf(const Picture& picture, const msg::Header& header) {
  const double f = picture.camera.focal_length_px();
  const double cx = picture.image.width / 2.0;
  const double cy = picture.image.height / 2.0;
  msg::CameraInfo info;
  info.header = header;
  info.width = static_cast<std::uint32_t>(picture.image.width);
  info.height = static_cast<std::uint32_t>(picture.image.height);
  info.distortion_model = "plumb_bob";
  info.d.assign(5, 0);
  info.k = {f, 0, cx, 0, f, cy, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0};
  return info;
}

msg::Image ImageOf(const msg::Header& header, int width, int height, const char* encoding,
                   std::size_t pixel_bytes, const void* data) {
  msg::Image image;
  image.header = header;
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  image.encoding = encoding;
  image.step = static_cast<std::uint32_t>(pixel_bytes) * image.width;
  image.data.resize(static_cast<std::size_t>(image.step) * image.height);
  std::memcpy(image.data.data(), data, image.data.size());
  return image;
}

/// X_WC of PinholeCamera looks along -z with y up.
Transform OpticalFrameOf(Transform X_WC) {
  for (std::size_t i = 4; i < 12; ++i) X_WC[i] = -X_WC[i];  // half a turn about x
  return X_WC;
}

}  // namespace

struct CameraTopics::Topics {
  Topics(Node& node, const std::string& frame_prefix, const std::string& camera)
      : frame(fmt::format("{}camera_{}_optical_frame", frame_prefix, camera)),
        image(node.Advertise<msg::Image>("camera/" + camera + "/image_raw", kPictures)),
        compressed(node.Advertise<msg::CompressedImage>(
            "camera/" + camera + "/image_raw/compressed", kPictures)),
        depth(node.Advertise<msg::Image>("camera/" + camera + "/depth/image_raw", kPictures)),
        info(node.Advertise<msg::CameraInfo>("camera/" + camera + "/camera_info", kSensor)) {}

  [[nodiscard]] bool has_readers() const {
    return image->has_readers() || compressed->has_readers() || depth->has_readers() ||
           info->has_readers();
  }

  const std::string frame;
  const std::unique_ptr<Publisher<msg::Image>> image;
  const std::unique_ptr<Publisher<msg::CompressedImage>> compressed;
  const std::unique_ptr<Publisher<msg::Image>> depth;
  const std::unique_ptr<Publisher<msg::CameraInfo>> info;
};

CameraTopics::CameraTopics(Node& node, Cameras cameras, std::function<msg::Time()> now)
    : node_(node),
      cameras_(std::move(cameras)),
      now_(std::move(now)),
      tf_(node.Advertise<msg::TFMessage>("/tf", {.depth = 100})),
      encoder_(kQuality) {
  for (const std::string& name : cameras_.names) {
    topics_.push_back(std::make_unique<Topics>(node, cameras_.frame_prefix, name));
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

CameraTopics::~CameraTopics() = default;

void CameraTopics::Publish(Topics& topics, const Picture& picture, const msg::Time& stamp) {
  const msg::Header header{.stamp = stamp, .frame_id = topics.frame};
  const render::Image& image = picture.image;
  if (topics.image->has_readers()) {
    topics.image->Publish(ImageOf(header, image.width, image.height, "rgb8", 3, image.rgb.data()));
  }
  if (topics.compressed->has_readers()) {
    const std::string bytes = encoder_.Encode(image);
    topics.compressed->Publish({.header = header,
                                .format = "rgb8; jpeg compressed bgr8",
                                .data = {bytes.begin(), bytes.end()}});
  }
  if (!picture.depth.depth_m.empty()) {
    topics.depth->Publish(ImageOf(header, picture.depth.width, picture.depth.height, "32FC1",
                                  sizeof(float), picture.depth.depth_m.data()));
  }
  topics.info->Publish(InfoOf(picture, header));
  if (tf_->has_readers()) {
    tf_->Publish(
        {.transforms = {FrameInWorld(topics.frame, OpticalFrameOf(picture.camera.X_WC()), stamp)}});
  }
}

void CameraTopics::Run(const std::stop_token& stop) {
  // Cannot fail: any thread may raise its nice value.
  static_cast<void>(rt::SetUpThisThread({.name = "twin-camera", .nice = 10, .lock_memory = false}));
  const twin::Duration period = FromSeconds(1 / cameras_.rate_hz);
  Time due = clock_.Now();
  while (!stop.stop_requested()) {
    try {
      for (std::size_t i = 0; i < topics_.size() && !stop.stop_requested(); ++i) {
        if (!topics_[i]->has_readers()) continue;
        const msg::Time stamp = now_();
        const auto picture = cameras_.paint(i, topics_[i]->depth->has_readers());
        if (picture) Publish(*topics_[i], *picture, stamp);
      }
    } catch (const Error& error) {
      return node_.Tell(fmt::format("ROS 2: no more pictures: {}", error.what()));
    }
    due = std::max(due + period, clock_.Now());
    rt::SleepUntil(clock_, due);
  }
}

}  // namespace twin::ros2
