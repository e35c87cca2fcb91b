#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "twin/core/clock.h"
#include "twin/render/contact_sheet.h"
#include "twin/render/film.h"

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

/// Called from the calling thread after each frame, with the frames done and their total.
using ClipProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Renders a film into a video and a contact sheet. Frames are drawn by several threads and encoded
/// in order by one.
/// @pre film.snapshots->size() > 0.
/// @throws what FramePainter, VideoWriter and WritePng throw.
ClipStats RenderClip(const Film& film, const ClipSettings& settings, const ClipPaths& paths,
                     const Clock& clock, const ClipProgress& progress = {});

}  // namespace twin::render
