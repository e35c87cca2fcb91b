#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/render/renderer.h"

namespace twin::render {

/// A point that should be seen on one of some bodies.
struct LinkPoint {
  std::string name;         ///< for messages
  std::vector<int> bodies;  ///< MuJoCo body ids
  Vector3 p_W{};            ///< the point in the world, m
};

/// How far a projected point is from the mask of its bodies.
struct LinkMaskCheck {
  std::string name;
  std::optional<PixelPoint> pixel;    ///< nothing: the point is behind the camera
  std::optional<double> distance_px;  ///< 0: on the mask; nothing: no pixel, or an empty mask
  std::size_t mask_pixels = 0;        ///< pixels of the bodies, nothing else being in the way
};

/// @returns the distance from `point` to the nearest pixel (a unit square) that shows one of
/// `bodies`: 0 inside; nothing when no pixel shows them.
[[nodiscard]] std::optional<double> DistanceToMask(const SegmentationImage& image,
                                                   std::span<const int> bodies,
                                                   const PixelPoint& point);

/// Checks the arm as it is drawn against the arm as it is computed: renders the mask of each
/// point's bodies, all other bodies taken away (links hide one another), and projects the point by
/// our own pinhole camera.
[[nodiscard]] std::vector<LinkMaskCheck> CheckLinkMasks(Renderer& renderer,
                                                        std::span<const double> qpos,
                                                        std::span<const LinkPoint> points);

/// The points to check on the arm, by our own kinematics (twin::model): at least one origin of a
/// joint frame for each of the links 0 to 7.
///
/// Link i carries the origins of two frames: joint i's, and the next one's, whose place in frame i
/// no joint changes. Looked for are those that lie in the link's shell: the base's on link 0, frame
/// n's on link n (n = 1, 2, 4, 5, 6), frame 4's on link 3 too, frame 7's on link 6 and the flange's
/// on link 7. (Frame 7's origin is 4.5 cm behind link 7; frame 3's is in no shell: it is 1 cm
/// before link 3, in the crook of the elbow.)
/// @param renderer  of a model with the bodies panda_link0 to panda_link7, its base at the origin
/// of the world. @param q  rad.
/// @throws InputError when a body is missing.
[[nodiscard]] std::vector<LinkPoint> ArmLinkPoints(const Renderer& renderer, const JointVector& q);

}  // namespace twin::render
