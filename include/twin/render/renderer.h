#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "twin/core/joint_vector.h"
#include "twin/render/image.h"
#include "twin/render/pinhole_camera.h"

struct mjModel_;

namespace twin::render {

/// What to draw and how well. The defaults are chosen for a clip: one Panda with all its visual
/// meshes, in software, on two cores.
struct RenderSettings {
  int width = 640;           ///< pixels, in [16, 4096]
  int height = 480;          ///< pixels, in [16, 4096]
  std::string camera;        ///< name of a camera of the model; empty: free_camera
  FreeCamera free_camera;    ///< used when `camera` is empty
  bool shadows = true;       ///< each light that casts shadows costs one more pass over all meshes
  int shadow_size = 768;     ///< texels along an edge of the shadow map, in [128, 8192]
  bool reflections = false;  ///< reflecting floors cost one more pass
  int samples = 0;           ///< per pixel, against jagged edges: 0, 2 or 4

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// What is drawn beside the model though it is not there: the model elsewhere, in one translucent
/// colour, and a line of small balls, as those of a planned path. Both cast shadows.
struct Ghost {
  static constexpr std::size_t kMostPoints = 400;

  /// The model elsewhere, as Renderer::Render()'s; drawn are the moving bodies that are not where
  /// they are really, by 4 mm or a degree. Empty: only the line.
  std::vector<double> qpos{};
  std::array<float, 4> colour{0.10F, 0.55F, 0.95F,
                              0.35F};  ///< red, green, blue, opacity, in [0, 1]
  std::vector<Vector3> line{};         ///< in the world, m; at most kMostPoints
  double radius = 0.007;               ///< of the line's balls, m
  std::array<float, 4> line_colour{0.95F, 0.35F, 0.05F, 1};
};

/// Draws a MuJoCo model without a window or a graphics card: MuJoCo's renderer on OSMesa.
///
/// It keeps a copy of the model and data of its own, so that the plant it shows may go on, or be
/// gone. Geoms of the groups 0, 1 and 2 are drawn; collision shapes belong into group 3 and above.
///
/// Same model, settings and qpos give the same bytes: on any renderer, thread and process, with any
/// number of Mesa's threads. What must be the same is the Mesa driver (llvmpipe; a process with
/// GALLIUM_DRIVER=softpipe draws otherwise), Mesa's version and a processor with AVX.
///
/// libEGL, libGLX and libGL must not be in the process: MuJoCo would take its OpenGL functions from
/// them, where no context is current.
///
/// Threads: one thread at a time, any thread. Not real-time.
class Renderer {
 public:
  /// @throws InputError for settings out of range or a camera that the model does not have (names
  /// those it has); EnvironmentError when OSMesa gives no context (says what to install).
  Renderer(const mjModel_& model, const RenderSettings& settings);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) = delete;

  /// @param qpos  generalised positions of the model, in its order. @pre qpos.size() == qpos_size()
  /// @param caption  text in the lower left corner (ASCII); empty: none.
  /// @returns the picture.
  [[nodiscard]] Image Render(std::span<const double> qpos, std::string_view caption = {});

  /// As Render(), with what is not there. @pre ghost.qpos is empty or of the model's size;
  /// ghost.line is not too long.
  [[nodiscard]] Image Render(std::span<const double> qpos, const Ghost& ghost,
                             std::string_view caption = {});

  /// @returns `qpos` with the arm elsewhere. @param q  rad.
  /// @throws InputError when the model does not have the joints panda_joint1 to panda_joint7.
  [[nodiscard]] std::vector<double> WithArmAt(std::span<const double> qpos,
                                              const JointVector& q) const;

  /// @returns `qpos` with a free body elsewhere. @param X_WB  its pose in the world.
  /// @throws InputError when the model has no free body of this name.
  [[nodiscard]] std::vector<double> WithBodyAt(std::span<const double> qpos,
                                               const std::string& body,
                                               const Transform& X_WB) const;

  /// @returns the body seen in each pixel.
  /// @param only_bodies  body ids; other bodies are taken away, so that what remains is not hidden
  /// by them. Empty: all bodies are there.
  [[nodiscard]] SegmentationImage Segment(std::span<const double> qpos,
                                          std::span<const int> only_bodies = {});

  /// @returns our own projection of the camera in use, at `qpos` (a camera of the model may be
  /// fixed to a moving body).
  [[nodiscard]] PinholeCamera Camera(std::span<const double> qpos);

  /// @returns the id of the body with this name.
  /// @throws InputError when there is none (names those there are).
  [[nodiscard]] int BodyId(std::string_view name) const;

  [[nodiscard]] std::size_t qpos_size() const noexcept;
  [[nodiscard]] const RenderSettings& settings() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::render
