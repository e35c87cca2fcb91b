#include "twin/scenario/render_section.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include "twin/scenario/names.h"
#include "twin/core/error.h"
#include "twin/core/require.h"

namespace twin::scenario {
namespace {

void Validate(const CameraSection& camera) {
  RequireInRange("render: camera.distance (m)", camera.distance, 0.01, 1000);
  RequireInRange("render: camera.turn (rad/s)", camera.turn, -2 * std::numbers::pi,
                 2 * std::numbers::pi);
  if (camera.kind == CameraKind::kScene && camera.name.empty()) {
    throw InputError("render: camera of the scene without a name");
  }
}

}  // namespace

void RenderSection::Validate() const {
  RequireInRange("render: width", width, 16, 4096);
  RequireInRange("render: height", height, 16, 4096);
  RequireInRange("render: fps", fps, 1, 240);
  if (width % 2 != 0 || height % 2 != 0) {
    throw InputError(
        fmt::format("render: {} x {} pixels; both must be even for H.264", width, height));
  }
  scenario::Validate(camera);
  for (const InsetSection& inset : insets) {
    scenario::Validate(inset.camera);
    RequireInRange("render: insets.share (%)", inset.share_percent, 10, 50);
  }
  for (std::size_t i = 0; i < insets.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (insets[k].corner != insets[i].corner) continue;
      throw InputError(fmt::format("render.insets: two at {}, where one hides the other; move one",
                                   NameOf(kPictureCornerNames, insets[i].corner)));
    }
  }
  for (std::size_t i = 0; i < overlays.size(); ++i) {
    if (std::count(overlays.begin(), overlays.end(), overlays[i]) > 1) {
      throw InputError(fmt::format("render.overlays: {} is there twice; leave one of them out",
                                   NameOf(kOverlayNames, overlays[i])));
    }
  }
}

}  // namespace twin::scenario
