#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "render/drawn_model.h"
#include "render/scene_renderer.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/record/scene_record.h"
#include "twin/render/snapshots.h"
#include "twin/render/view.h"

namespace twin::render {

using Colour = std::array<float, 4>;  ///< red, green, blue, opacity, in [0, 1]

/// A small ball. @param p_W  m. @param radius  m.
[[nodiscard]] mjvGeom Ball(const Vector3& p_W, double radius, const Colour& colour);

/// A cylinder between two points.
[[nodiscard]] mjvGeom Rod(const Vector3& from_W, const Vector3& to_W, double radius,
                          const Colour& colour);

/// An arrow with its tip at the point of force. @param newton_m  length per newton, m.
[[nodiscard]] mjvGeom ForceArrow(const record::PointForce& force, double newton_m,
                                 const Colour& colour);

/// Positions a view's camera for a frame.
class CameraRig {
 public:
  /// @throws InputError if the model lacks the camera or body.
  CameraRig(const View& view, const DrawnModel& model);

  /// @param since  time since the film's start.
  void Aim(Duration since, const mjData& data, Shot& shot) const;

 private:
  View view_;
  int id_ = -1;  ///< of the camera, or of the body that is tracked or carries the camera
};

/// Past path of the tool: the point between the fingers, or the flange without a hand.
class ToolTrace {
 public:
  ToolTrace() = default;
  /// @param before  snapshots before the frames; may be null.
  /// @throws InputError if the model has neither hand nor arm.
  ToolTrace(const DrawnModel& model, const Snapshots* before, const Snapshots& frames);

  /// Appends the path up to a frame. @param seconds  length of the trace.
  void Append(std::size_t frame, double seconds, const Colour& colour,
              std::vector<mjvGeom>& marks) const;

 private:
  struct Point {
    double at_s = 0;
    Vector3 p_W{};
  };
  void Follow(const DrawnModel& model, const Snapshots& snapshots);

  std::vector<Point> points_;  ///< those before the frames, then one per frame
  std::size_t before_ = 0;     ///< number of points before the frames
};

/// Seven bars in the lower right corner, base to wrist from left to right. Each is a joint's range,
/// upper limit at the top, with a slider at its position; amber within a tenth of the range from a
/// limit, red within a fiftieth.
class JointBars {
 public:
  JointBars() = default;
  /// @throws InputError if the model has no arm.
  explicit JointBars(const DrawnModel& model);

  /// @pre scene's context is in use.
  void Draw(const mjData& data, const SceneRenderer& scene) const;

 private:
  struct Joint {
    int position = 0;  ///< in qpos
    double lower = 0;
    double upper = 0;
  };
  std::array<Joint, kJoints> joints_{};
};

}  // namespace twin::render
