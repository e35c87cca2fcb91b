#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/render/renderer.h"

namespace twin::render {

/// A point that should appear on one of several bodies.
struct LinkPoint {
  std::string name;         ///< for messages
  std::vector<int> bodies;  ///< MuJoCo body ids
  Vector3 p_W{};            ///< the point in the world, m
};

/// Distance of a projected point from the mask of its bodies.
struct LinkMaskCheck {
  std::string name;
  std::optional<PixelPoint> pixel;    ///< nullopt: the point is behind the camera
  std::optional<double> distance_px;  ///< 0: on the mask; nullopt: no pixel, or an empty mask
  std::size_t mask_pixels = 0;        ///< pixels of the bodies, unoccluded
};

/// @returns the distance from `point` to the nearest pixel (a unit square) that shows one of
/// `bodies`: 0 inside; nullopt if no pixel shows them.
[[nodiscard]] std::optional<double> DistanceToMask(const SegmentationImage& image,
                                                   std::span<const int> bodies,
                                                   const PixelPoint& point);

/// Checks the drawn arm against the computed one: renders the mask of each point's bodies without
/// other bodies (links occlude one another), and projects the point with our own pinhole camera.
[[nodiscard]] std::vector<LinkMaskCheck> CheckLinkMasks(Renderer& renderer,
                                                        std::span<const double> qpos,
                                                        std::span<const LinkPoint> points);

/// Points to check on the arm, by our own kinematics (twin::model): at least one origin of a joint
/// frame for each of the links 0 to 7.
///
/// Link i carries the origins of two frames: joint i's, and the next one's, which is fixed in frame
/// i. Used are the origins inside the link's shell: the base's on link 0, frame n's on link n (n =
/// 1, 2, 4, 5, 6), frame 4's also on link 3, frame 7's on link 6 and the flange's on link 7. (Frame
/// 7's origin is 4.5 cm behind link 7. Frame 3's is in no shell, 1 cm in front of link 3.)
/// @param renderer  of a model with the bodies panda_link0 to panda_link7, its base at the origin
/// of the world. @param q  rad.
/// @throws InputError if a body is missing.
[[nodiscard]] std::vector<LinkPoint> ArmLinkPoints(const Renderer& renderer, const JointVector& q);

}  // namespace twin::render
