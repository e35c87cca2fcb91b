#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "twin/application/application.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Two pictures of a moment; empty paths: none was made.
struct MomentPictures {
  std::filesystem::path planned;  ///< PNG
  std::filesystem::path done;     ///< PNG
};

/// What the page tells beside deeds and judgement.
struct PageFacts {
  std::vector<std::pair<std::string, std::string>> lines{};  ///< "lab": "a"; as a table
  std::vector<MomentPictures> moments{};       ///< one for each of the deeds' moments, or none
  std::vector<std::filesystem::path> plots{};  ///< SVG files of the whole run
  bool has_video = false;                      ///< video.mp4 lies beside the page
};

/// Whether the task was carried out and all that is demanded is met.
[[nodiscard]] bool Succeeded(const Deeds& deeds, const Judgement& judgement) noexcept;

/// Why not: the step that failed, else the first demand that was missed; empty when it succeeded.
[[nodiscard]] std::string FailureOf(const Deeds& deeds, const Judgement& judgement);

/// The page of a run: how it went, what is demanded and whether that is met, the steps, pairs of
/// pictures, figures, plots. One HTML file with everything in it but the video.
/// @throws EnvironmentError when a picture or plot cannot be read.
[[nodiscard]] std::string PageOf(const scenario::Scenario& scenario, const Deeds& deeds,
                                 const Judgement& judgement, const PageFacts& facts);

}  // namespace twin::application
