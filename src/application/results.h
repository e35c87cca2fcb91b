#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "twin/application/application.h"
#include "twin/run/summary.h"

// Results of an application's run: summary.json, summary on the terminal, report.html.
namespace twin::application {

struct ApplicationResult {
  TaskResult task_result;
  Evaluation evaluation;
  run::SessionResult session;
  bool interrupted = false;
};

/// summary.json: in lockstep the same bytes for the same scenario and seed.
[[nodiscard]] std::string SummaryJson(const scenario::Scenario& scenario,
                                      const ApplicationResult& result,
                                      const std::optional<plant::ContactWatch>& contacts);

/// The summary on the terminal.
[[nodiscard]] std::string SummaryText(const scenario::Scenario& scenario,
                                      const ApplicationResult& result, const run::WallTimes& times);

/// Two pictures of a planned motion, PNG; empty paths: none.
struct PicturePair {
  std::filesystem::path planned;
  std::filesystem::path done;
};

/// Contents of the page in addition to task_result and evaluation.
struct PageFacts {
  std::vector<std::pair<std::string, std::string>> lines{};  ///< "lab": "a"; as a table
  std::vector<PicturePair> pictures{};                       ///< one per plan of the task, or none
  std::vector<std::filesystem::path> plots{};                ///< SVG files of the whole run
  bool has_video = false;                                    ///< video.mp4 is in the page's folder
};

/// The report: outcome, demands, steps, pairs of pictures, figures, plots. One HTML file with
/// everything except the video. @throws EnvironmentError if a picture or plot cannot be read.
[[nodiscard]] std::string PageOf(const scenario::Scenario& scenario, const TaskResult& task_result,
                                 const Evaluation& evaluation, const PageFacts& facts);

}  // namespace twin::application
