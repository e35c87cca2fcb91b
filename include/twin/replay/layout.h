#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "twin/core/joint_vector.h"
#include "twin/render/film.h"
#include "twin/render/image.h"
#include "twin/replay/recording.h"

namespace twin::replay {

/// A page of pictures, as the paper's figures show its applications.
enum class Layout : std::uint8_t {
  kGrid,   ///< 2 x 2: compliance A, B, C, D, each where the arm is furthest from its way, with what
           ///< pushes it as an arrow and the way as dots
  kStrip,  ///< of six plans: above, when it was planned, with its goal as a ghost; below, done
  kTriple,  ///< of each plan a row: initial, plan with ghost and way, final
};

/// @throws InputError when there is none of this name (names those there are).
[[nodiscard]] Layout LayoutFromName(std::string_view name);

/// Draws a layout, each picture of the settings' size, between borders.
///
/// A strip of more than six plans takes six, evenly spaced, the first and the last among them. What
/// is furthest is sought in the snapshots, from when a plan was made until it was done: the largest
/// distance of the end effector from the plan's way, or from where it was, of a plan without one.
///
/// @param settings  edges are smoothed, and overlays are the layout's own but for the text.
/// Threads: any. @throws InputError when the log lacks the plans it takes (names those it has);
/// what render::FramePainter throws.
[[nodiscard]] render::Image DrawLayout(const Recording& recording, Layout layout,
                                       const render::FilmSettings& settings);

/// How far a point is from a way of points, joined by straight lines; m.
/// @pre at least one point.
[[nodiscard]] double DistanceFromWay(const Vector3& point, std::span<const Vector3> way);

}  // namespace twin::replay
