#include <string>

#include <fmt/format.h>

#include "twin/scenario/names.h"
#include "scenario/quoted.h"
#include "scenario/section_writers.h"
#include "twin/core/quantity.h"

namespace twin::scenario {
namespace {

std::string CameraText(const CameraSection& camera) {
  if (camera.kind == CameraKind::kScene) return Quoted(camera.name);
  if (camera.kind == CameraKind::kGripper) return std::string(kGripperCamera);
  std::string text = fmt::format(
      "{{azimuth: {} rad, elevation: {} rad, distance: {} m, lookat: [{} m, {} m, {} m], turn: {} "
      "rad/s",
      FormatNumber(camera.azimuth), FormatNumber(camera.elevation), FormatNumber(camera.distance),
      FormatNumber(camera.lookat[0]), FormatNumber(camera.lookat[1]),
      FormatNumber(camera.lookat[2]), FormatNumber(camera.turn));
  if (!camera.track.empty()) text += fmt::format(", track: {}", Quoted(camera.track));
  return text + "}";
}

}  // namespace

std::string RenderText(const RenderSection& render) {
  std::string text = fmt::format(
      "render:\n  enabled: {}\n  width: {}\n  height: {}\n  fps: {} Hz\n  camera: {}\n",
      render.enabled, render.width, render.height, render.fps, CameraText(render.camera));
  std::string overlays;
  for (const Overlay overlay : render.overlays) {
    overlays += (overlays.empty() ? "" : ", ") + std::string(NameOf(kOverlayNames, overlay));
  }
  text += fmt::format("  overlays: [{}]\n", overlays);
  if (render.insets.empty()) return text;
  text += "  insets:\n";
  for (const InsetSection& inset : render.insets) {
    text +=
        fmt::format("    - {{camera: {}, corner: {}, share: {} %}}\n", CameraText(inset.camera),
                    NameOf(kPictureCornerNames, inset.corner), FormatNumber(inset.share_percent));
  }
  return text;
}

}  // namespace twin::scenario
