#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "twin/scenario/render_section.h"

namespace twin::scenario {

/// A view of a case.
struct VideoView {
  std::string name;  ///< letters, digits, '_' and '-'
  RenderSection render;
};

/// A run whose pictures are compared with approved ones.
///
///     scenario: applications/pick_and_place.yaml   # in the models folder
///     lab: b                     # laid over it; absent: none
///     seed: 7                    # absent: the scenario's
///     every: 5                   # frame of its video is looked at; 1 unless said
///     key_frames: 5              # of those are kept whole, evenly spaced; 5 unless said
///     views:                     # each as a scenario's render section; 320 x 240 unless said
///       overview: {overlays: [text, goal]}
///       hand: {camera: {track: panda_hand, distance: 0.5 m}, overlays: []}
struct VideoCase {
  std::string name;                ///< of the file, without its extension
  std::filesystem::path scenario;  ///< relative to the models folder
  std::optional<std::string> lab;
  std::optional<std::uint64_t> seed;
  std::size_t every = 1;       ///< in [1, 10000]
  std::size_t key_frames = 5;  ///< in [2, 100]
  std::vector<VideoView> views;
};

/// @throws InputError "<file>:<line>: <key>: ..." for anything invalid.
[[nodiscard]] VideoCase LoadVideoCase(const std::filesystem::path& path);

}  // namespace twin::scenario
