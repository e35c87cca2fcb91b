#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/core/joint_vector.h"

namespace twin::scenario {

enum class CameraKind : std::uint8_t {
  kOrbit,    ///< looks at a point of the world, or at a body that it follows
  kScene,    ///< of the scene, by its name
  kGripper,  ///< on the flange, looking at the fingers
};

/// From where a run is seen.
struct CameraSection {
  CameraKind kind = CameraKind::kOrbit;
  std::string name{};                               ///< kScene
  double azimuth = 142 * std::numbers::pi / 180;    ///< kOrbit, as all that follow; rad
  double elevation = -18 * std::numbers::pi / 180;  ///< rad
  double distance = 2.05;                           ///< m, in [0.01, 1000]
  Vector3 lookat{0.18, 0, 0.46};                    ///< m, in the world; from the body if it tracks
  std::string track{};                              ///< body that it follows; empty: none
  double turn = 0;                                  ///< of the azimuth, rad/s, in [-2 pi, 2 pi]
  bool operator==(const CameraSection&) const = default;
};

enum class PictureCorner : std::uint8_t { kTopLeft, kTopRight, kBottomLeft, kBottomRight };

/// A second camera's picture within the first one's.
struct InsetSection {
  CameraSection camera;
  PictureCorner corner = PictureCorner::kTopRight;
  double share_percent = 30;  ///< of width and height, %, in [10, 50]
  bool operator==(const InsetSection&) const = default;
};

/// What is drawn over a picture.
enum class Overlay : std::uint8_t {
  kText,      ///< time, title, events
  kGoal,      ///< what was planned: ghost and way
  kTrace,     ///< where the tool has been
  kForces,    ///< contact forces and pushes, as arrows
  kContacts,  ///< where anything touches
  kLimits,    ///< where each joint is between its limits
};

/// How scenarios and flags spell these.
inline constexpr std::array<std::pair<std::string_view, PictureCorner>, 4> kPictureCornerNames{
    {{"top_left", PictureCorner::kTopLeft},
     {"top_right", PictureCorner::kTopRight},
     {"bottom_left", PictureCorner::kBottomLeft},
     {"bottom_right", PictureCorner::kBottomRight}}};

inline constexpr std::array<std::pair<std::string_view, Overlay>, 6> kOverlayNames{
    {{"text", Overlay::kText},
     {"goal", Overlay::kGoal},
     {"trace", Overlay::kTrace},
     {"forces", Overlay::kForces},
     {"contacts", Overlay::kContacts},
     {"limits", Overlay::kLimits}}};

/// The camera on the flange; no scene's camera of this name can be chosen.
inline constexpr std::string_view kGripperCamera = "gripper";

/// The video of a run.
struct RenderSection {
  bool enabled = true;
  int width = 640;   ///< pixels, even, in [16, 4096]
  int height = 480;  ///< pixels, even, in [16, 4096]
  int fps = 25;      ///< in [1, 240]
  CameraSection camera;
  std::vector<InsetSection> insets{};
  std::vector<Overlay> overlays{Overlay::kText};  ///< each at most once
  bool operator==(const RenderSection&) const = default;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace twin::scenario
