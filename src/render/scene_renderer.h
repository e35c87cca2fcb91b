#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "render/osmesa_context.h"
#include "twin/render/image.h"
#include "twin/render/renderer.h"

namespace twin::render {

/// A camera with an arbitrary frame, which MuJoCo's cameras do not permit.
struct CameraFrame {
  Vector3 p_W{};
  Vector3 forward_W{};
  Vector3 up_W{};
};

/// X_WC of a camera of the model; C as in PinholeCamera.
inline Transform CameraPose(const mjData& data, std::ptrdiff_t id) {
  const mjtNum* const R = data.cam_xmat + 9 * id;  // row-major
  const mjtNum* const p = data.cam_xpos + 3 * id;
  return {R[0], R[3], R[6], 0, R[1], R[4], R[7], 0, R[2], R[5], R[8], 0, p[0], p[1], p[2], 1};
}

/// Content of one rendering pass.
struct Shot {
  mjData* data = nullptr;  ///< with positions set
  mjvCamera camera{};
  std::optional<CameraFrame> frame{};  ///< replaces the camera's frame, with its field of view
  mjData* elsewhere = nullptr;  ///< the model at another position, as Ghost::qpos; may be null
  std::array<float, 4> elsewhere_colour{};
  std::span<const mjvGeom> marks{};  ///< drawn in addition to the model
};

/// MuJoCo's abstract scene and its rendering, in one OpenGL context.
///
/// Use() makes the context current for a scope, so that calls may come from any thread; all other
/// calls require such a scope.
class SceneRenderer {
 public:
  using Current = OsMesaContext::Current;

  /// @param model  with off-screen buffer and shadow map sizes set. Must outlive this object.
  SceneRenderer(const mjModel& model, const RenderSettings& settings);
  ~SceneRenderer();
  SceneRenderer(const SceneRenderer&) = delete;
  SceneRenderer& operator=(const SceneRenderer&) = delete;

  [[nodiscard]] Current Use() { return Current(gl_); }

  /// Draws into a part of the off-screen buffer, replacing its content.
  void Draw(const Shot& shot, mjrRect viewport);
  /// Writes text into a corner, over the picture. @param where  an mjtGridPos.
  void Write(int where, const std::string& text);
  /// Fills a rectangle. @param colour  red, green, blue, opacity.
  void Fill(mjrRect rectangle, const std::array<float, 4>& colour) const;
  [[nodiscard]] mjrRect Whole() const noexcept { return {0, 0, settings_.width, settings_.height}; }
  /// @returns the drawn picture, top row first, as the functions below.
  [[nodiscard]] Image Read() const;

  /// @returns distances along the camera's axis.
  [[nodiscard]] DepthImage Measure(const Shot& shot);
  /// @param only_bodies  other bodies are removed; empty: all bodies.
  [[nodiscard]] SegmentationImage Segment(const Shot& shot, std::span<const int> only_bodies);

 private:
  void UpdateScene(const Shot& shot);
  /// Adds the moving geoms whose poses differ to the scene, in one colour.
  void AddElsewhere(const Shot& shot);
  /// Removes the geoms of all other bodies from the scene.
  void KeepBodies(std::span<const int> bodies);
  /// @returns the body for each colour of an id-coloured picture.
  [[nodiscard]] std::vector<std::int32_t> BodiesByColour() const;

  const mjModel& model_;
  RenderSettings settings_;
  OsMesaContext gl_;
  mjvOption option_;
  mjvScene scene_;
  mjrContext context_;
};

}  // namespace twin::render
