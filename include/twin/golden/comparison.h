#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/golden/difference.h"
#include "twin/golden/golden.h"
#include "twin/golden/pictures.h"

namespace twin::golden {

/// Checks of the pictures, in this order. The first two compare bits and alone fail nothing,
/// because other processors and rasterisers give other bits; they separate changes of physics from
/// changes of rendering.
enum class Gate : std::uint8_t {
  kStates,        ///< the run's states are approved, bit by bit
  kHashes,        ///< all frames are approved, bit by bit
  kFrames,        ///< the number of frames is the same
  kSignatures,    ///< every frame, downscaled: largest difference of a channel, levels
  kColours,       ///< key pictures: percent of differing channels
  kColourWindow,  ///< differing pixels in the fullest window
  kDepths,        ///< percent of pixels with differing depth
  kDepthWindow,   ///< pixels with differing depth in the fullest window
  kBodies,        ///< percent of pixels that show another body
  kBodyWindow,    ///< pixels that show another body in the fullest window
  kSsim,          ///< 1 - structural similarity by ffmpeg
};
inline constexpr std::size_t kGates = 11;

/// Name in reports and verdicts.
[[nodiscard]] std::string_view Name(Gate gate) noexcept;
/// Measured quantity, with its unit.
[[nodiscard]] std::string_view Meaning(Gate gate) noexcept;

/// Tolerances. src/golden/README.md has the measurements behind them.
struct Limits {
  int signature_levels = 5;  ///< 8-bit
  /// Drake's rendering tests require 99.5 % of the channels within 1/255; so does this gate, except
  /// for scenery.
  ColourTolerance colour;
  double colour_percent = 0.5;
  double depth_m = 1e-3;
  double depth_percent = 0.5;
  double body_percent = 0.5;
  int window_px = 16;
  int window_pixels = 12;  ///< of 256; the same for colours, depths and bodies
  double dissimilarity = 0.01;
};

/// Location of a difference.
struct Place {
  std::size_t frame = 0;
  std::string view{};  ///< empty: the whole film
  Region region{};     ///< in the view's pixels
  std::string body{};  ///< in the region; empty: unknown
};

/// Result of one gate.
struct GateResult {
  Gate gate{};
  bool passed = true;
  double worst = 0;                 ///< largest measured value
  double limit = 0;                 ///< largest value that passes
  std::optional<Place> worst_at{};  ///< nullopt without a difference
  std::optional<Place> first{};     ///< first failure; nullopt if the gate passed
};

enum class Verdict : std::uint8_t {
  kSame,              ///< states and frames are approved ones
  kRenderingOnly,     ///< approved states; frames differ in bits but look the same
  kStatesOnly,        ///< other states; the frames look the same
  kRenderingChanged,  ///< approved states; pictures differ
  kPhysicsChanged,    ///< other states; pictures differ
};

/// Result of a case.
struct Comparison {
  Verdict verdict = Verdict::kSame;
  std::array<GateResult, kGates> gates{};  ///< in the order of Gate

  /// True if every gate except the first two passed.
  [[nodiscard]] bool passed() const noexcept {
    return verdict != Verdict::kRenderingChanged && verdict != Verdict::kPhysicsChanged;
  }
  /// The failed gate with the earliest frame; among several, one that names a body of the run, then
  /// the first in order. @returns null if all passed.
  [[nodiscard]] const GateResult* FirstFailure() const noexcept;
};

/// The verdict as a sentence for users, with first frame, region, body and gate.
[[nodiscard]] std::string Describe(const Comparison& comparison, const Pictures& pictures);

/// The run's side of a comparison.
struct Evidence {
  const Pictures* pictures = nullptr;  ///< of the run
  std::uint64_t states = 0;            ///< hash of the run's states
  /// Returns the bodies in any frame of a view (by index), numbered as in the film. Called for the
  /// first frame with a differing signature, if it is not a key picture. May be empty.
  std::function<render::SegmentationImage(std::size_t view, std::size_t frame)> look;
};

/// Compares a run's pictures with the approved ones; matches bodies by name.
/// @param ffmpeg  as render::VideoSettings::ffmpeg.
/// @throws InputError if views, sizes or interval differ, which prevents a comparison;
/// EnvironmentError as render::MeasureSsim.
[[nodiscard]] Comparison Compare(const Golden& golden, const Evidence& evidence,
                                 const Limits& limits = {},
                                 const std::filesystem::path& ffmpeg = "ffmpeg");

}  // namespace twin::golden
