#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

struct mjModel_;
struct mjData_;

namespace twin::render {

/// The visible shapes of a model in one file, for a viewer that draws them itself: the geometries
/// that Renderer draws (groups 0 to 2, not fully transparent), lights and colours of the sky.
///
///     4 bytes   n, little endian, a multiple of 4: length of the description
///     n bytes   description, JSON, padded with spaces
///     the rest  arrays, little endian, which the description names by their offset from here
///
/// The description has the members
///   bodies     number of the model's bodies; body 0 is the world
///   base       body of the arm's first link; 0 if the model has none
///   sky        colours above and below; null without a sky
///   ambient    light from everywhere; headlight: light from the viewer
///   lights     each with `to` (direction in the world), `colour` and `shadow`
///   textures   each with `at`, `width`, `height`: rows of red, green, blue; 8 bits each
///   meshes     each with `at`, `vertices`, `faces`: positions (m) and normals of the vertices, 3
///              float32 each, then 3 uint32 per face
///   geoms      each with `body`, `type` (plane, sphere, capsule, ellipsoid, cylinder, box, mesh),
///              `size` as in MuJoCo's geom_size, `pos` and `quat` (w, x, y, z) in its body,
///              `colour` (red, green, blue, opacity), `specular`, `shininess`, `mesh` (index or
///              -1), `texture` (of a plane: index or -1), `repeat` (of the texture)
///   left_out   number of height fields, which the file does not contain
/// Colours are in [0, 1], as MuJoCo has them.
///
/// Threads: any. Not real-time.
[[nodiscard]] std::string SceneShapes(const mjModel_& model);

/// Poses of a model's bodies, by its kinematics alone.
///
/// Threads: one. Not real-time.
class BodyPoses {
 public:
  /// @param model  must outlive this object. @throws EnvironmentError with MuJoCo's reason.
  explicit BodyPoses(const mjModel_& model);
  ~BodyPoses();
  BodyPoses(const BodyPoses&) = delete;
  BodyPoses& operator=(const BodyPoses&) = delete;

  /// @param qpos  generalised positions, as a SceneRecord has them. @pre qpos has the model's size.
  /// @returns x, y, z (m), then w, x, y, z of a unit quaternion, in the world, for each body from
  /// body 1 on. Valid until the next call.
  [[nodiscard]] std::span<const double> At(std::span<const double> qpos);

 private:
  struct FreeData {
    void operator()(mjData_* data) const noexcept;
  };
  const mjModel_& model_;
  const std::unique_ptr<mjData_, FreeData> data_;
  std::vector<double> poses_;
};

}  // namespace twin::render
