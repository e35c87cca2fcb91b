#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "twin/core/clock.h"
#include "twin/render/contact_sheet.h"
#include "twin/render/renderer.h"
#include "twin/render/snapshots.h"

namespace twin::render {

struct ClipSettings {
  RenderSettings render;
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

/// Renders snapshots of a run into a video and a contact sheet, each frame with its time in a
/// corner. Frames are drawn by several threads and encoded in order by one.
/// @param model  the model the snapshots are of.
/// @pre snapshots.qpos_size() is the model's, snapshots.size() > 0.
/// @throws what Renderer, VideoWriter and WritePng throw.
ClipStats RenderClip(const mjModel_& model, const Snapshots& snapshots,
                     const ClipSettings& settings, const ClipPaths& paths, const Clock& clock,
                     const ClipProgress& progress = {});

}  // namespace twin::render
