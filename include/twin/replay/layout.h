#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "twin/core/joint_vector.h"
#include "twin/render/film.h"
#include "twin/render/image.h"
#include "twin/replay/recording.h"

namespace twin::replay {

/// Arrangement of pictures, as in the paper's figures of its applications.
enum class Layout : std::uint8_t {
  kGrid,    ///< 2 x 2: compliance A to D, each at the arm's largest deviation from its path, with
            ///< pushes as arrows and the path as dots
  kStrip,   ///< six plans: above, at planning time, with the goal as a ghost; below, when done
  kTriple,  ///< one row per plan: initial, plan with ghost and path, final
};

/// @throws InputError if the name is unknown (lists the known ones).
[[nodiscard]] Layout LayoutFromName(std::string_view name);

/// Draws a layout; each picture has the settings' size and a border.
///
/// A strip of more than six plans takes six, evenly spaced, with the first and the last. The
/// largest deviation is searched in the snapshots between a plan's start and end: the largest
/// distance of the end effector from the plan's path, or from its start position if the plan has no
/// path.
///
/// @param settings  edges are smoothed; the layout sets the overlays except the text.
/// Threads: any. @throws InputError if the log lacks the required plans (lists those it has); the
/// errors of render::FramePainter.
[[nodiscard]] render::Image DrawLayout(const Recording& recording, Layout layout,
                                       const render::FilmSettings& settings);

/// Distance of a point from a polyline, m.
/// @pre at least one point.
[[nodiscard]] double DistanceFromPath(const Vector3& point, std::span<const Vector3> path);

}  // namespace twin::replay
