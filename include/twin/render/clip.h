#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "twin/core/clock.h"
#include "twin/render/film.h"
#include "twin/render/image.h"
#include "twin/render/image_operations.h"

namespace twin::render {

struct ClipSettings {
  FilmSettings film;
  int crf = 20;                             ///< see VideoSettings
  std::filesystem::path ffmpeg = "ffmpeg";  ///< see VideoSettings
  ContactSheetLayout sheet;
  int sheet_pictures = 12;  ///< evenly spaced, with the first and the last frame; >= 1
};

/// Paths of the results; an empty path omits the result.
struct ClipPaths {
  std::filesystem::path video;
  std::filesystem::path contact_sheet;
};

struct ClipStats {
  std::size_t frames = 0;
  double seconds = 0;  ///< by the given clock
};

/// Draws any frame of a clip, in any order.
using DrawFrame = std::function<Image(std::size_t frame)>;

/// The frames of a clip, from any source.
struct ClipFrames {
  std::size_t count = 0;  ///< >= 1
  int fps = 25;           ///< of the clip, in [1, 240]
  int width = 640;        ///< of each frame, pixels, even
  int height = 480;       ///< pixels, even
  /// Called once on the drawing thread, which alone uses the result.
  std::function<DrawFrame()> new_drawer;
};

/// The frames of a film. @param film, settings  must outlive the result and its drawers.
/// @pre film.snapshots->size() > 0.
[[nodiscard]] ClipFrames FramesOf(const Film& film, const FilmSettings& settings);

/// Called on the calling thread after each frame, with the number of finished and of all frames.
using ClipProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Renders a film to a video and a contact sheet. One thread draws, the calling one encodes.
/// @pre film.snapshots->size() > 0.
/// @throws what FramePainter, VideoWriter and WritePng throw.
ClipStats RenderClip(const Film& film, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress = {});

/// As above for any frames. @param settings  its film settings are ignored.
/// @throws what the drawers, VideoWriter and WritePng throw.
ClipStats RenderClip(const ClipFrames& frames, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress = {});

}  // namespace twin::render
