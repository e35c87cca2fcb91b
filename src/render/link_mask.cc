#include "twin/render/link_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "twin/model/arm_model.h"

namespace twin::render {
namespace {

bool Contains(std::span<const int> bodies, std::int32_t body) {
  return std::find(bodies.begin(), bodies.end(), body) != bodies.end();
}

/// Distance on one axis from `x` to the interval [pixel, pixel + 1].
double AxisDistance(double x, int pixel) {
  return std::max({pixel - x, x - pixel - 1, 0.0});
}

using model::Frame;

/// A joint frame's origin and the link whose shell contains it.
struct FrameOnLink {
  Frame frame;
  int link;
};
constexpr std::array<FrameOnLink, 8> kFramesOnLinks{{{Frame::kJoint1, 1},
                                                     {Frame::kJoint2, 2},
                                                     {Frame::kJoint4, 3},
                                                     {Frame::kJoint4, 4},
                                                     {Frame::kJoint5, 5},
                                                     {Frame::kJoint6, 6},
                                                     {Frame::kJoint7, 6},
                                                     {Frame::kFlange, 7}}};

LinkPoint MakePoint(const Renderer& renderer, int link, const Vector3& p_W) {
  const std::string name = "panda_link" + std::to_string(link);
  return {name, {renderer.BodyId(name)}, p_W};
}

}  // namespace

std::optional<double> DistanceToMask(const SegmentationImage& image, std::span<const int> bodies,
                                     const PixelPoint& point) {
  std::optional<double> nearest;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (!Contains(bodies, image.at(column, row))) continue;
      const double distance = std::hypot(AxisDistance(point.u, column), AxisDistance(point.v, row));
      if (!nearest || distance < *nearest) nearest = distance;
    }
  }
  return nearest;
}

std::vector<LinkMaskCheck> CheckLinkMasks(Renderer& renderer, std::span<const double> qpos,
                                          std::span<const LinkPoint> points) {
  const PinholeCamera camera = renderer.Camera(qpos);
  std::vector<LinkMaskCheck> checks;
  for (const LinkPoint& point : points) {
    const SegmentationImage mask = renderer.Segment(qpos, point.bodies);
    LinkMaskCheck check{point.name, camera.Project(point.p_W), std::nullopt, 0};
    check.mask_pixels = static_cast<std::size_t>(
        std::count_if(mask.body.begin(), mask.body.end(),
                      [&](std::int32_t body) { return Contains(point.bodies, body); }));
    if (check.pixel) check.distance_px = DistanceToMask(mask, point.bodies, *check.pixel);
    checks.push_back(std::move(check));
  }
  return checks;
}

std::vector<LinkPoint> ArmLinkPoints(const Renderer& renderer, const JointVector& q) {
  std::vector<LinkPoint> points{MakePoint(renderer, 0, {0, 0, 0})};
  for (const auto& [frame, link] : kFramesOnLinks) {
    const Transform O_T_frame = model::ArmModel::Panda().Pose(frame, q);
    points.push_back(MakePoint(renderer, link, {O_T_frame[12], O_T_frame[13], O_T_frame[14]}));
  }
  return points;
}

}  // namespace twin::render
