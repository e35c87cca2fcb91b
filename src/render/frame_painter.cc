#include "twin/render/frame_painter.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "render/drawn_model.h"
#include "render/frame_parts.h"
#include "render/scene_renderer.h"
#include "twin/core/error.h"

namespace twin::render {
namespace {

constexpr Colour kTraceColour{0.98F, 0.75F, 0.10F, 1};
constexpr Colour kContactColour{0.90F, 0.10F, 0.10F, 1};
constexpr Colour kContactForceColour{0.95F, 0.35F, 0.10F, 1};
constexpr Colour kPushColour{0.55F, 0.20F, 0.85F, 1};

/// Display time of a note, unless the next comes earlier.
constexpr Duration kNoteStays = std::chrono::milliseconds(2500);

mjrRect PlaceOf(const Inset& inset, const mjrRect& whole) {
  constexpr int kMargin = 6;
  const int width = static_cast<int>(std::lround(inset.share * whole.width));
  const int height = static_cast<int>(std::lround(inset.share * whole.height));
  const bool right = inset.corner == Corner::kTopRight || inset.corner == Corner::kBottomRight;
  const bool top = inset.corner == Corner::kTopLeft || inset.corner == Corner::kTopRight;
  return {right ? whole.width - width - kMargin : kMargin,
          top ? whole.height - height - kMargin : kMargin, width, height};
}

/// X_WC of a frame that looks along `forward`; C as in PinholeCamera.
Transform PoseOf(const CameraFrame& frame) {
  const Vector3& f = frame.forward_W;
  const Vector3& u = frame.up_W;
  const Vector3 r{f[1] * u[2] - f[2] * u[1], f[2] * u[0] - f[0] * u[2], f[0] * u[1] - f[1] * u[0]};
  return {r[0],  r[1],  r[2],  0, u[0],         u[1],         u[2],         0,
          -f[0], -f[1], -f[2], 0, frame.p_W[0], frame.p_W[1], frame.p_W[2], 1};
}

}  // namespace

class FramePainter::Impl {
 public:
  Impl(Film film, FilmSettings settings)
      : film_(std::move(film)),
        settings_(std::move(settings)),
        model_(*film_.model, settings_.render),
        data_(model_.NewData()),
        elsewhere_(model_.NewData()),
        camera_(settings_.view, model_),
        trace_(settings_.overlays.trace ? ToolTrace(model_, film_.before, *film_.snapshots)
                                        : ToolTrace()),
        bars_(settings_.overlays.limits ? JointBars(model_) : JointBars()),
        scene_(model_.get(), settings_.render) {
    for (const Inset& inset : settings_.insets) insets_.emplace_back(inset.view, model_);
  }

  [[nodiscard]] const PlannedGoal* GoalOf(std::size_t frame) const {
    if (!settings_.overlays.goal) return nullptr;
    const Time at = film_.snapshots->time(frame);
    const auto found =
        std::find_if(film_.goals.rbegin(), film_.goals.rend(),
                     [&](const PlannedGoal& goal) { return goal.from <= at && at < goal.until; });
    return found == film_.goals.rend() ? nullptr : &*found;
  }

  /// @param goal  may be null.
  Image Paint(std::size_t frame, const PlannedGoal* goal) {
    Shot shot = ShotOf(frame);
    if (goal != nullptr) PutElsewhere(*goal, film_.snapshots->qpos(frame), shot);
    const std::vector<mjvGeom> marks = MarksOf(frame, goal);
    shot.marks = marks;
    const SceneRenderer::Current current = scene_.Use();
    scene_.Draw(shot, scene_.Whole());
    for (std::size_t i = 0; i < insets_.size(); ++i) DrawInset(i, frame, shot);
    if (settings_.overlays.limits) bars_.Draw(*data_, scene_);
    if (settings_.overlays.text) WriteTexts(film_.snapshots->time(frame));
    return scene_.Read();
  }

  DepthImage Depth(std::size_t frame) {
    const Shot shot = ShotOf(frame);
    const SceneRenderer::Current current = scene_.Use();
    return scene_.Measure(shot);
  }

  PinholeCamera Camera(std::size_t frame) {
    const Shot shot = ShotOf(frame);
    const double fovy = model_.get().vis.global.fovy;
    const int width = settings_.render.width;
    const int height = settings_.render.height;
    if (shot.frame) return PinholeCamera(PoseOf(*shot.frame), fovy, width, height);
    if (shot.camera.type == mjCAMERA_FIXED) {
      const auto id = static_cast<std::ptrdiff_t>(shot.camera.fixedcamid);
      return PinholeCamera(CameraPose(*data_, id), model_.get().cam_fovy[id], width, height);
    }
    FreeCamera free{.azimuth_deg = shot.camera.azimuth,
                    .elevation_deg = shot.camera.elevation,
                    .distance_m = shot.camera.distance};
    std::copy_n(shot.camera.lookat, 3, free.lookat_m.begin());
    return PinholeCamera::FromFreeCamera(free, fovy, width, height);
  }

  SegmentationImage Segment(std::size_t frame) {
    const Shot shot = ShotOf(frame);
    const SceneRenderer::Current current = scene_.Use();
    return scene_.Segment(shot, {});
  }

 private:
  [[nodiscard]] Duration Since(std::size_t frame) const {
    return film_.snapshots->time(frame) - film_.snapshots->time(0);
  }

  Shot ShotOf(std::size_t frame) {
    TWIN_CHECK(frame < film_.snapshots->size());
    model_.SetPositions(film_.snapshots->qpos(frame), *data_);
    Shot shot;
    shot.data = data_.get();
    camera_.Aim(Since(frame), *data_, shot);
    return shot;
  }

  void PutElsewhere(const PlannedGoal& goal, std::span<const double> qpos, Shot& shot) {
    if (!goal.q && goal.object.empty()) return;
    std::vector<double> there(qpos.begin(), qpos.end());
    if (goal.q) there = model_.WithArmAt(there, *goal.q);
    if (!goal.object.empty()) there = model_.WithBodyAt(there, goal.object, goal.O_T_object);
    model_.SetPositions(there, *elsewhere_);
    shot.elsewhere = elsewhere_.get();
    shot.elsewhere_colour = Ghost{}.colour;
  }

  [[nodiscard]] std::vector<mjvGeom> MarksOf(std::size_t frame, const PlannedGoal* goal) const {
    const Overlays& wanted = settings_.overlays;
    const record::SceneRecord& scene = film_.snapshots->scene(frame);
    std::vector<mjvGeom> marks;
    if (goal != nullptr) {
      const Ghost style;
      for (const Vector3& point : goal->path) {
        marks.push_back(Ball(point, style.radius, style.line_colour));
      }
    }
    if (wanted.trace) trace_.Append(frame, settings_.trace_s, kTraceColour, marks);
    if (wanted.contacts) {
      for (const record::PointForce& contact : scene.Contacts()) {
        marks.push_back(Ball(contact.p_W, 0.006, kContactColour));
      }
    }
    if (wanted.forces) {
      for (const record::PointForce& contact : scene.Contacts()) {
        marks.push_back(ForceArrow(contact, settings_.newton_m, kContactForceColour));
      }
      for (const record::PointForce& push : scene.Pushes()) {
        marks.push_back(ForceArrow(push, settings_.newton_m, kPushColour));
      }
    }
    return marks;
  }

  void DrawInset(std::size_t number, std::size_t frame, Shot shot) {
    const mjrRect place = PlaceOf(settings_.insets[number], scene_.Whole());
    constexpr int kFrame = 2;
    scene_.Fill({place.left - kFrame, place.bottom - kFrame, place.width + 2 * kFrame,
                 place.height + 2 * kFrame},
                {0.1F, 0.1F, 0.12F, 1});
    shot.elsewhere = nullptr;  // a ghost of the hand would fill the gripper's view
    insets_[number].Aim(Since(frame), *data_, shot);
    scene_.Draw(shot, place);
  }

  void WriteTexts(Time at) {
    if (!film_.title.empty()) scene_.Write(mjGRID_TOPLEFT, film_.title);
    // One below the other: side by side they would overlap in a small picture.
    const std::string note = NoteAt(at);
    const std::string time = fmt::format("t = {:.2f} s", ToSeconds(at.time_since_epoch()));
    scene_.Write(mjGRID_BOTTOMLEFT, note.empty() ? time : note + "\n" + time);
  }

  [[nodiscard]] std::string NoteAt(Time at) const {
    const auto next =
        std::upper_bound(film_.notes.begin(), film_.notes.end(), at,
                         [](Time time, const FilmNote& note) { return time < note.at; });
    if (next == film_.notes.begin()) return {};
    const FilmNote& note = *std::prev(next);
    return at - note.at < kNoteStays ? note.text : std::string();
  }

  Film film_;
  FilmSettings settings_;
  DrawnModel model_;
  DrawnModel::DataPointer data_;
  DrawnModel::DataPointer elsewhere_;
  CameraRig camera_;
  std::vector<CameraRig> insets_;
  ToolTrace trace_;
  JointBars bars_;
  SceneRenderer scene_;
};

FramePainter::FramePainter(const Film& film, const FilmSettings& settings) {
  TWIN_CHECK(film.model != nullptr && film.snapshots != nullptr);
  settings.Validate();
  impl_ = MujocoCall(
      "The off-screen renderer cannot start (it needs Debian's libosmesa6, and no "
      "libEGL or libGL in the process)",
      [&] { return std::make_unique<Impl>(film, settings); });
}

FramePainter::~FramePainter() = default;
FramePainter::FramePainter(FramePainter&&) noexcept = default;

Image FramePainter::Paint(std::size_t frame) {
  return MujocoCall("A frame cannot be drawn",
                    [&] { return impl_->Paint(frame, impl_->GoalOf(frame)); });
}

Image FramePainter::Paint(std::size_t frame, const PlannedGoal& goal) {
  return MujocoCall("A frame cannot be drawn", [&] { return impl_->Paint(frame, &goal); });
}

DepthImage FramePainter::Depth(std::size_t frame) {
  return MujocoCall("A depth picture cannot be drawn", [&] { return impl_->Depth(frame); });
}

PinholeCamera FramePainter::Camera(std::size_t frame) {
  return MujocoCall("A camera cannot be placed", [&] { return impl_->Camera(frame); });
}

SegmentationImage FramePainter::Segment(std::size_t frame) {
  return MujocoCall("A segmentation cannot be drawn", [&] { return impl_->Segment(frame); });
}

}  // namespace twin::render
