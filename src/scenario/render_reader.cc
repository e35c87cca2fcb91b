#include <numbers>

#include "scenario/section_readers.h"

namespace twin::scenario {
namespace {

/// A camera that orbits a point, or follows a body.
void ReadOrbit(const YamlNode& node, CameraSection& camera) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const YamlMap map = node.Map({"azimuth", "elevation", "distance", "lookat", "track", "turn"});
  camera.kind = CameraKind::kOrbit;
  IfGiven(map, "track", [&](const YamlNode& n) {
    camera.track = n.Text();
    camera.lookat = {};  // seen from the body, unless given
  });
  IfGiven(map, "azimuth", [&](const YamlNode& n) {
    camera.azimuth = n.Quantity(Dimension::kAngle, -kTurn, kTurn);
  });
  IfGiven(map, "elevation", [&](const YamlNode& n) {
    camera.elevation = n.Quantity(Dimension::kAngle, -kTurn / 4, kTurn / 4);
  });
  IfGiven(map, "distance",
          [&](const YamlNode& n) { camera.distance = n.Quantity(Dimension::kLength, 0.01, 1000); });
  IfGiven(map, "lookat",
          [&](const YamlNode& n) { camera.lookat = n.Vector(Dimension::kLength, -1000, 1000); });
  IfGiven(map, "turn", [&](const YamlNode& n) {
    camera.turn = n.Quantity(Dimension::kAngularVelocity, -kTurn, kTurn);
  });
}

/// "gripper", the name of one of the scene's cameras, or a camera that orbits.
void ReadCamera(const YamlNode& node, CameraSection& camera) {
  if (!node.IsScalar()) return ReadOrbit(node, camera);
  const std::string name = node.Text();
  if (name == kGripperCamera) {
    camera.kind = CameraKind::kGripper;
    return;
  }
  camera.kind = CameraKind::kScene;
  camera.name = name;
}

InsetSection ReadInset(const YamlNode& node) {
  const YamlMap map = node.Map({"camera", "corner", "share"});
  InsetSection inset;
  ReadCamera(map.Require("camera"), inset.camera);
  IfGiven(map, "corner",
          [&](const YamlNode& n) { inset.corner = ReadChoice(n, kPictureCornerNames); });
  IfGiven(map, "share", [&](const YamlNode& n) {
    inset.share_percent = n.Quantity(Dimension::kPercent, 10, 50);
  });
  return inset;
}

int ReadFrameRate(const YamlNode& node) {
  const double fps = node.Quantity(Dimension::kFrequency, 1, 240);
  const int whole = static_cast<int>(fps);
  if (fps != whole) node.Fail("must be whole Hz");
  return whole;
}

}  // namespace

void ReadRender(const YamlNode& node, RenderSection& render) {
  const YamlMap map =
      node.Map({"enabled", "width", "height", "fps", "camera", "insets", "overlays"});
  const auto integer = [](const YamlNode& n, std::uint64_t least, std::uint64_t most) {
    return static_cast<int>(n.Integer(least, most));
  };
  IfGiven(map, "enabled", [&](const YamlNode& n) { render.enabled = n.Bool(); });
  IfGiven(map, "width", [&](const YamlNode& n) { render.width = integer(n, 16, 4096); });
  IfGiven(map, "height", [&](const YamlNode& n) { render.height = integer(n, 16, 4096); });
  IfGiven(map, "fps", [&](const YamlNode& n) { render.fps = ReadFrameRate(n); });
  IfGiven(map, "camera", [&](const YamlNode& n) { ReadCamera(n, render.camera); });
  IfGiven(map, "insets", [&](const YamlNode& n) {
    for (const YamlNode& item : n.Items()) render.insets.push_back(ReadInset(item));
  });
  IfGiven(map, "overlays", [&](const YamlNode& n) {
    render.overlays.clear();
    for (const YamlNode& item : n.Items()) {
      render.overlays.push_back(ReadChoice(item, kOverlayNames));
    }
  });
}

}  // namespace twin::scenario
