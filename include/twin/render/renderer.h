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

/// Content and quality of a picture. The defaults suit a clip of one Panda with all visual meshes,
/// rendered in software on two cores.
struct RenderSettings {
  int width = 640;           ///< pixels, in [16, 4096]
  int height = 480;          ///< pixels, in [16, 4096]
  std::string camera;        ///< name of a camera of the model; empty: free_camera
  FreeCamera free_camera;    ///< used when `camera` is empty
  bool shadows = true;       ///< each light with shadows costs one more pass over all meshes
  int shadow_size = 768;     ///< texels along an edge of the shadow map, in [128, 8192]
  bool reflections = false;  ///< reflecting floors cost one more pass
  int samples = 0;           ///< per pixel, for anti-aliasing: 0, 2 or 4

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Objects drawn in addition to the model: the model at another position in one translucent colour,
/// and a line of small balls, such as a planned path. Both cast shadows.
struct Ghost {
  static constexpr std::size_t kMostPoints = 400;

  /// Position of the second model, as in Renderer::Render(); draws the moving bodies that differ
  /// from their real pose by 4 mm or a degree. Empty: only the line.
  std::vector<double> qpos{};
  std::array<float, 4> colour{0.10F, 0.55F, 0.95F,
                              0.35F};  ///< red, green, blue, opacity, in [0, 1]
  std::vector<Vector3> line{};         ///< in the world, m; at most kMostPoints
  double radius = 0.007;               ///< of the balls, m
  std::array<float, 4> line_colour{0.95F, 0.35F, 0.05F, 1};
};

/// Draws a MuJoCo model without window or graphics card: MuJoCo's renderer on OSMesa.
///
/// Keeps its own copy of the model and data, so that the displayed plant may continue or be
/// destroyed. Draws geoms of groups 0, 1 and 2; collision shapes belong in group 3 and above.
///
/// Same model, settings and qpos give the same bytes on any renderer, thread and process, with any
/// number of Mesa threads. This requires the same Mesa driver (llvmpipe; with
/// GALLIUM_DRIVER=softpipe pictures differ), the same Mesa version and a processor with AVX.
///
/// libEGL, libGLX and libGL must not be loaded in the process: MuJoCo would take its OpenGL
/// functions from them, where no context is current.
///
/// Threads: any, one at a time. Not real-time.
class Renderer {
 public:
  /// @throws InputError for settings out of range or an unknown camera (lists the known ones);
  /// EnvironmentError if OSMesa gives no context (what to install), and in a fork after drawing.
  Renderer(const mjModel_& model, const RenderSettings& settings);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) = delete;

  /// @param qpos  generalised positions of the model, in its order. @pre qpos.size() == qpos_size()
  /// @param caption  text in the lower left corner (ASCII); empty: none.
  /// @returns the picture.
  [[nodiscard]] Image Render(std::span<const double> qpos, std::string_view caption = {});

  /// As Render(), with a ghost. @pre ghost.qpos is empty or of the model's size; ghost.line has at
  /// most kMostPoints.
  [[nodiscard]] Image Render(std::span<const double> qpos, const Ghost& ghost,
                             std::string_view caption = {});

  /// @returns `qpos` with the arm at q. @param q  rad.
  /// @throws InputError if the model lacks the joints panda_joint1 to panda_joint7.
  [[nodiscard]] std::vector<double> WithArmAt(std::span<const double> qpos,
                                              const JointVector& q) const;

  /// @returns `qpos` with a free body at X_WB. @param X_WB  its pose in the world.
  /// @throws InputError if the model has no free body of this name.
  [[nodiscard]] std::vector<double> WithBodyAt(std::span<const double> qpos,
                                               const std::string& body,
                                               const Transform& X_WB) const;

  /// @returns the body seen in each pixel.
  /// @param only_bodies  body ids; other bodies are removed, so that they do not occlude these.
  /// Empty: all bodies.
  [[nodiscard]] SegmentationImage Segment(std::span<const double> qpos,
                                          std::span<const int> only_bodies = {});

  /// @returns our own projection for the current camera at `qpos` (a model's camera may be fixed to
  /// a moving body).
  [[nodiscard]] PinholeCamera Camera(std::span<const double> qpos);

  /// @returns the id of the body with this name.
  /// @throws InputError if the name is unknown (lists the known ones).
  [[nodiscard]] int BodyId(std::string_view name) const;

  [[nodiscard]] std::size_t qpos_size() const noexcept;
  [[nodiscard]] const RenderSettings& settings() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::render

struct mjModel_;

namespace twin::render {

/// @returns the names of a model's bodies by id, as in a SegmentationImage; the first is "world".
/// An unnamed body is called "body <id>".
[[nodiscard]] std::vector<std::string> BodyNames(const mjModel_& model);

}  // namespace twin::render
