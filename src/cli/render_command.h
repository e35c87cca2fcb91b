#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/film_flags.h"

namespace twin::cli {

struct RenderFlags {
  std::filesystem::path log;                    ///< or a run's folder
  std::optional<std::filesystem::path> second;  ///< of another run, to compare with
  std::filesystem::path out;
  FilmFlags film;
  double speed = 1;
  std::optional<int> fps;
  std::optional<double> from;  ///< s of the run, as the following
  std::optional<double> until;
  std::optional<double> at;  ///< one picture
  std::string compare = "split";
  std::optional<int> tolerance;  ///< absent: 16
  std::optional<std::string> layout;
  bool quiet = false;
  DataFlags data;
};

/// Draws a recorded run, or two: a video, a picture, or a page of pictures. @throws twin::Error;
/// Interrupted.
[[nodiscard]] ExitCode RenderCommand(const RenderFlags& flags, const Host& host);

}  // namespace twin::cli
