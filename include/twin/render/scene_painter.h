#pragma once

#include "twin/record/scene_record.h"
#include "twin/render/film.h"
#include "twin/render/frame_painter.h"
#include "twin/render/image.h"
#include "twin/render/snapshots.h"

struct mjModel_;

namespace twin::render {

/// Draws scenes as they come, for pictures of a robot that moves now.
///
/// Threads: one at a time, any.
class ScenePainter {
 public:
  /// @param model  must outlive this. @param scene  of the model. @throws as FramePainter.
  ScenePainter(const mjModel_& model, const record::SceneRecord& scene,
               const FilmSettings& settings)
      : snapshots_(OneScene(scene)),
        painter_({.model = &model, .snapshots = &snapshots_}, settings) {}
  ScenePainter(const ScenePainter&) = delete;
  ScenePainter& operator=(const ScenePainter&) = delete;

  /// What the next calls draw.
  void Show(const record::SceneRecord& scene) { snapshots_ = OneScene(scene); }
  [[nodiscard]] Image Paint() { return painter_.Paint(0); }
  [[nodiscard]] DepthImage Depth() { return painter_.Depth(0); }
  [[nodiscard]] PinholeCamera Camera() { return painter_.Camera(0); }

 private:
  static Snapshots OneScene(const record::SceneRecord& scene) {
    Snapshots snapshots(1, scene.positions);  // a single one has no rate
    snapshots.Append(scene);
    return snapshots;
  }

  Snapshots snapshots_;  ///< referenced by painter_
  FramePainter painter_;
};

}  // namespace twin::render
