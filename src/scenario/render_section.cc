#include "twin/scenario/render_section.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "twin/core/error.h"
#include "twin/core/text.h"

namespace twin::scenario {

using enum Dimension;

namespace {

/// "gripper", the name of one of the scene's cameras, or a camera that orbits.
Value CameraOf(CameraSection& camera) {
  Value name = Word("a camera of the scene, or gripper", ".", [&camera](const YamlNode& node) {
    camera.name = node.Text();
    camera.kind = camera.name == kGripperCamera ? CameraKind::kGripper : CameraKind::kScene;
    if (camera.kind == CameraKind::kGripper) camera.name.clear();
  });
  name.write = [&camera](int /*indent*/) {
    return camera.kind == CameraKind::kScene ? YamlQuoted(camera.name)
                                             : std::string(kGripperCamera);
  };
  return Defined(
      "camera", "View of a run: a camera that looks at a point or follows a body, or a name.",
      Either(name, SectionOf(camera), [&camera] { return camera.kind != CameraKind::kOrbit; }));
}

}  // namespace

static void Describe(Map& map, InsetSection& inset) {
  map.Require("camera", CameraOf(inset.camera), "View of the picture.");
  map.Add("corner", Choice(inset.corner, kPictureCornerNames), "Where it is drawn.");
  map.Add("share", Quantity(inset.share_percent, kPercent, 10, 50), "Share of width and height.");
}

void Describe(Map& map, CameraSection& camera) {
  map.Before([&camera](const YamlNode& /*node*/) { camera.kind = CameraKind::kOrbit; });
  map.Add("azimuth", Quantity(camera.azimuth, kAngle, -kTurn, kTurn), "Direction about z.");
  map.Add("elevation", Quantity(camera.elevation, kAngle, -kTurn / 4, kTurn / 4),
          "Above the horizon; negative: looks down.");
  map.Add("distance", Quantity(camera.distance, kLength, 0.01, 1000), "Distance from lookat.");
  map.Add("lookat", Vector(camera.lookat, kLength, -1000, 1000),
          "In the world; with track seen from the body, and then zero unless given.");
  map.Add("turn", Quantity(camera.turn, kAngularVelocity, -kTurn, kTurn),
          "Velocity of the azimuth.");
  map.Add("track", Text(camera.track), "A body to follow.")
      .OmitIf(camera.track.empty())
      .Then([&map, &camera](const YamlNode& /*node*/) {
        if (!map.Given("lookat")) camera.lookat = {};
      });
}

void Describe(Map& map, RenderSection& render) {
  map.Add("enabled", Bool(render.enabled), "Whether the run is filmed.");
  map.Add("width", Integer(render.width, 16, 4096), "Pixels, even.");
  map.Add("height", Integer(render.height, 16, 4096), "Pixels, even.");
  const auto rate = [](double& fps) {
    Value value = Quantity(fps, kFrequency, 1, 240);
    value.read = [&fps, read = value.read](const YamlNode& node) {
      read(node);
      if (fps != std::floor(fps)) node.Fail("must be whole Hz");
    };
    return value;
  };
  map.Add("fps",
          Converted(static_cast<double>(render.fps), rate,
                    [&render](double fps) { render.fps = static_cast<int>(fps); }),
          "Frames per second, whole.");
  map.Add("camera", CameraOf(render.camera), "View of the run.");
  const auto overlay = [](Overlay& one) { return Choice(one, kOverlayNames); };
  map.Add("overlays", List(render.overlays, overlay),
          "text: time, title, events; goal: what was planned; trace: of the tool; forces: of "
          "contacts and pushes; contacts; limits: where each joint is between its own.");
  map.Add("insets", ListOf(render.insets), "Pictures within the picture.")
      .OmitIf(render.insets.empty());
}

void RenderSection::Validate() const {
  if (width % 2 != 0 || height % 2 != 0) {
    throw InputError(
        fmt::format("render: {} x {} pixels; both must be even for H.264", width, height));
  }
  const auto is_nameless = [](const CameraSection& one) {
    return one.kind == CameraKind::kScene && one.name.empty();
  };
  if (is_nameless(camera) || std::ranges::any_of(insets, is_nameless, &InsetSection::camera)) {
    throw InputError("render: camera of the scene without a name");
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
