#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "twin/application/application.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Two pictures of a snapshot; empty paths: none was made.
struct SnapshotPictures {
  std::filesystem::path planned;  ///< PNG
  std::filesystem::path done;     ///< PNG
};

/// What the page tells beside task_result and evaluation.
struct PageFacts {
  std::vector<std::pair<std::string, std::string>> lines{};  ///< "lab": "a"; as a table
  std::vector<SnapshotPictures>
      snapshots{};  ///< one for each of the task_result' snapshots, or none
  std::vector<std::filesystem::path> plots{};  ///< SVG files of the whole run
  bool has_video = false;                      ///< video.mp4 lies beside the page
};

/// Whether the task was carried out and all that is demanded is met.
[[nodiscard]] bool Succeeded(const TaskResult& task_result, const Evaluation& evaluation) noexcept;

/// Why not: the step that failed, else the first demand that was missed; empty when it succeeded.
[[nodiscard]] std::string FailureOf(const TaskResult& task_result, const Evaluation& evaluation);

/// The page of a run: how it went, what is demanded and whether that is met, the steps, pairs of
/// pictures, figures, plots. One HTML file with everything in it but the video.
/// @throws EnvironmentError when a picture or plot cannot be read.
[[nodiscard]] std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                                 const Evaluation& evaluation, const PageFacts& facts);

}  // namespace twin::application
