#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "twin/core/clock.h"
#include "twin/render/contact_sheet.h"
#include "twin/render/film.h"
#include "twin/render/image.h"

namespace twin::render {

struct ClipSettings {
  FilmSettings film;
  int crf = 20;                             ///< see VideoSettings
  std::filesystem::path ffmpeg = "ffmpeg";  ///< see VideoSettings
  ContactSheetLayout sheet;
  int sheet_pictures = 12;  ///< evenly spaced, the first and the last frame among them; >= 1
  int render_threads = 2;   ///< in [1, 16]; the pictures do not depend on it
};

/// Where the results go; an empty path: that one is not made.
struct ClipPaths {
  std::filesystem::path video;
  std::filesystem::path contact_sheet;
};

struct ClipStats {
  std::size_t frames = 0;
  double seconds = 0;  ///< by the clock passed in
};

/// Draws a frame of a clip, any of them, in any order.
using DrawFrame = std::function<Image(std::size_t frame)>;

/// Frames that make a clip, whatever it is that draws them.
struct ClipFrames {
  std::size_t count = 0;  ///< >= 1
  int fps = 25;           ///< of the clip, in [1, 240]
  int width = 640;        ///< of each frame, pixels, even
  int height = 480;       ///< pixels, even
  /// Called once on each thread that draws; what it gives is used by that thread alone.
  std::function<DrawFrame()> new_drawer;
};

/// The frames of a film. @param film, settings  must outlive what is returned and its drawers.
/// @pre film.snapshots->size() > 0.
[[nodiscard]] ClipFrames FramesOf(const Film& film, const FilmSettings& settings);

/// Called from the calling thread after each frame, with the frames done and their total.
using ClipProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Renders a film into a video and a contact sheet. Frames are drawn by several threads and encoded
/// in order by one.
/// @pre film.snapshots->size() > 0.
/// @throws what FramePainter, VideoWriter and WritePng throw.
ClipStats RenderClip(const Film& film, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress = {});

/// The same of frames that are no film's. @param settings  its film counts for nothing.
/// @throws what the drawers, VideoWriter and WritePng throw.
ClipStats RenderClip(const ClipFrames& frames, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress = {});

}  // namespace twin::render
