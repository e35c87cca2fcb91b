#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "twin/core/time.h"
#include "twin/render/scene_shapes.h"
#include "twin/render/view.h"

struct mjModel_;

namespace twin::page {

/// Generalised positions of a model at a time of the run's clock.
struct Placed {
  Time at{};
  std::span<const double> qpos;  ///< valid until the next call of its source
};

/// The scene for browsers that draw it themselves: its shapes as a file, the poses of its bodies as
/// messages. Draws nothing.
///
/// Threads: one.
class LiveScene {
 public:
  /// The newest positions, if there are new ones.
  using Source = std::function<std::optional<Placed>()>;

  /// @param model  must outlive this object. @param view  the viewpoint to begin with; where it
  /// cannot be used outside the renderer, a default. @param note  what viewers should know of what
  /// they see; may be empty.
  LiveScene(const mjModel_& model, Source newest, const render::View& view, std::string_view note);

  /// The file of render::SceneShapes().
  [[nodiscard]] const std::string& file() const noexcept { return file_; }
  /// "/scene/" and a hash of the file: another content has another path, so browsers may keep it.
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  /// A JSON object: `path`, `note`, and the first `view` with azimuth and elevation (degrees),
  /// distance (m) and lookat (m; null: the arm).
  [[nodiscard]] const std::string& description() const noexcept { return description_; }
  /// The newest poses, members of a JSON object; empty before the first scene.
  [[nodiscard]] const std::string& Poses();

 private:
  const Source newest_;
  render::BodyPoses bodies_;
  const std::string file_;
  const std::string path_;
  const std::string description_;
  std::string poses_;
};

}  // namespace twin::page
