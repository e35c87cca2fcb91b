#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <functional>
#include <span>
#include <string>

#include "render/osmesa_context.h"
#include "twin/render/image.h"
#include "twin/render/renderer.h"

namespace twin::render {

/// The OpenGL half of Renderer: MuJoCo's abstract scene and its drawing, in one context.
///
/// Every call makes the context current, and releases it, so that calls may come from any thread.
class SceneRenderer {
 public:
  /// @param model  with the sizes of its off-screen buffer and shadow map set. Must outlive this.
  SceneRenderer(const mjModel& model, const RenderSettings& settings);
  ~SceneRenderer();
  SceneRenderer(const SceneRenderer&) = delete;
  SceneRenderer& operator=(const SceneRenderer&) = delete;

  /// @param ghost, elsewhere  what is drawn though it is not there, and the model's positions
  /// there; may be null, the second when the first is.
  [[nodiscard]] Image Draw(mjData& data, mjvCamera camera, const std::string& caption,
                           const Ghost* ghost = nullptr, mjData* elsewhere = nullptr);
  [[nodiscard]] SegmentationImage Segment(mjData& data, mjvCamera camera,
                                          std::span<const int> only_bodies);

 private:
  void UpdateScene(mjData& data, mjvCamera& camera);
  /// Adds the moving geoms that are not alike in both to the scene, in one colour.
  void AddElsewhere(const mjData& data, mjData& elsewhere, const std::array<float, 4>& colour);
  void AddLine(const Ghost& ghost);
  /// Takes the geoms of all bodies but these out of the scene.
  void KeepBodies(std::span<const int> bodies);
  /// Reads the off-screen buffer, top row first.
  [[nodiscard]] Image ReadPixels() const;
  [[nodiscard]] mjrRect Viewport() const noexcept;
  /// @returns the body a pixel of an id-coloured picture stands for.
  [[nodiscard]] std::int32_t BodyOfColour(Rgb colour, std::span<const std::int32_t> bodies) const;

  const mjModel& model_;
  RenderSettings settings_;
  OsMesaContext gl_;
  mjvOption option_;
  mjvScene scene_;
  mjrContext context_;
};

}  // namespace twin::render
