#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "twin/render/clip.h"
#include "twin/render/film.h"
#include "twin/replay/recording.h"
#include "twin/replay/time_line.h"

namespace twin::replay {

/// Layout of two runs in one picture.
enum class ComparisonKind : std::uint8_t {
  kSplit,       ///< side by side: twice as wide as the settings say
  kGhost,       ///< the second's arm, translucent, in the first's picture, without its objects
  kDifference,  ///< the first in grey, red where a channel differs by more than the tolerance
};

/// @throws InputError if the name is unknown (lists the known ones).
[[nodiscard]] ComparisonKind ComparisonFromName(std::string_view name);

struct ComparisonSettings {
  ComparisonKind kind = ComparisonKind::kSplit;
  render::FilmSettings film;
  TimeLine time_line;  ///< of the first run
  int tolerance = 16;  ///< kDifference: of 255, in [0, 254]
};

/// Two runs in one clip, each on its own time since its first record. When the shorter one has
/// ended, its last frame stays, marked as ended.
///
/// The runs may differ in model, scene and seed. A view must exist in both, except for kGhost,
/// which shows only the first's scene.
///
/// Threads: any; immutable after construction.
class Comparison {
 public:
  /// @param first, second  must outlive this object. @param labels  of the two, for the pictures.
  /// @throws InputError for a setting out of range, and as FrameTimes.
  Comparison(const Recording& first, const Recording& second, const ComparisonSettings& settings,
             const std::array<std::string, 2>& labels);
  ~Comparison();
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  /// For render::RenderClip. Refers to this object. Drawing throws as render::FramePainter.
  [[nodiscard]] render::ClipFrames Frames() const;

  /// Differences in what is drawn of the two, one line each: length, model, source of frames.
  [[nodiscard]] std::vector<std::string> Notes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The first picture in grey, red where a channel of the two plain pictures differs by more than
/// `tolerance`. @pre all have one size.
[[nodiscard]] render::Image HighlightDifference(const render::Image& shown,
                                                const render::Image& first,
                                                const render::Image& second, int tolerance);

/// Two pictures side by side with a light line of two pixels between them. @pre equal heights.
[[nodiscard]] render::Image SideBySide(const render::Image& left, const render::Image& right);

}  // namespace twin::replay
