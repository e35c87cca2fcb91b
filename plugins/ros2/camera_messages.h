#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "plugins/ros2/messages.h"

// Messages of cameras, of sensor_msgs (common_interfaces), as messages.h has its own. Frames of
// cameras look along +z, x is to the right (REP 103); lengths are pixels where not told otherwise.
// A test compares bytes and hashes with those of rosbags.
namespace twin::ros2 {
namespace msg {

struct Image {
  static constexpr const char* kName = "sensor_msgs/msg/Image";
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;  ///< "rgb8", "32FC1" (depth, m), "16UC1" (depth, mm), ...
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;  ///< bytes of a row
  std::vector<std::uint8_t> data;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("encoding", m.encoding);
    v("is_bigendian", m.is_bigendian);
    v("step", m.step);
    v("data", m.data);
  }
};

struct CompressedImage {
  static constexpr const char* kName = "sensor_msgs/msg/CompressedImage";
  Header header;
  std::string format;  ///< "jpeg", "png", ...
  std::vector<std::uint8_t> data;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("format", m.format);
    v("data", m.data);
  }
};

struct RegionOfInterest {
  static constexpr const char* kName = "sensor_msgs/msg/RegionOfInterest";
  std::uint32_t x_offset = 0;
  std::uint32_t y_offset = 0;
  std::uint32_t height = 0;  ///< 0, with width 0: the whole image
  std::uint32_t width = 0;
  bool do_rectify = false;
  static void Visit(auto& m, auto&& v) {
    v("x_offset", m.x_offset);
    v("y_offset", m.y_offset);
    v("height", m.height);
    v("width", m.width);
    v("do_rectify", m.do_rectify);
  }
};

/// Matrices are by rows.
struct CameraInfo {
  static constexpr const char* kName = "sensor_msgs/msg/CameraInfo";
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;  ///< "plumb_bob", ...
  std::vector<double> d;         ///< its parameters
  std::array<double, 9> k{};     ///< intrinsic, 3x3
  std::array<double, 9> r{};     ///< rectification, 3x3
  std::array<double, 12> p{};    ///< projection, 3x4
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
  RegionOfInterest roi;
  static void Visit(auto& m, auto&& v) {
    v("header", m.header);
    v("height", m.height);
    v("width", m.width);
    v("distortion_model", m.distortion_model);
    v("d", m.d);
    v("k", m.k);
    v("r", m.r);
    v("p", m.p);
    v("binning_x", m.binning_x);
    v("binning_y", m.binning_y);
    v("roi", m.roi);
  }
};

}  // namespace msg

/// Calls visitor.operator()<M>() for each message above.
void ForEachCameraMessage(auto&& visitor) {
  visitor.template operator()<msg::Image>();
  visitor.template operator()<msg::CompressedImage>();
  visitor.template operator()<msg::RegionOfInterest>();
  visitor.template operator()<msg::CameraInfo>();
}

}  // namespace twin::ros2
