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

/// What is asked of pictures, in this order. The first two only know what was approved again; they
/// tell a change of physics from one of rendering, and alone fail nothing, since another processor
/// or rasteriser has other bits.
enum class Gate : std::uint8_t {
  kStates,        ///< the run's states are approved ones, bit by bit
  kHashes,        ///< so are all frames
  kFrames,        ///< there are as many frames
  kSignatures,    ///< every frame, made small: levels of the channel most off
  kColours,       ///< key pictures: percent of channels that are off
  kColourWindow,  ///< pixels off in the fullest window
  kDepths,        ///< percent of pixels whose depth is off
  kDepthWindow,   ///< pixels whose depth is off in the fullest window
  kBodies,        ///< percent of pixels that show another body
  kBodyWindow,    ///< pixels that show another body in the fullest window
  kSsim,          ///< 1 - structural similarity, ffmpeg's
};
inline constexpr std::size_t kGates = 11;

/// Its name, in reports and verdicts.
[[nodiscard]] std::string_view Name(Gate gate) noexcept;
/// What it measures, with its unit.
[[nodiscard]] std::string_view Meaning(Gate gate) noexcept;

/// How much is let pass. src/golden/README.md tells what was measured to choose it.
struct Limits {
  int signature_levels = 5;  ///< 8-bit
  /// Drake's tests of rendering ask for 99.5 % of the channels within 1/255, as is done here of
  /// what is not scenery.
  ColourTolerance colour;
  double colour_percent = 0.5;
  double depth_m = 1e-3;
  double depth_percent = 0.5;
  double body_percent = 0.5;
  int window_px = 16;
  int window_pixels = 12;  ///< of 256; the same for colours, depths and bodies
  double dissimilarity = 0.01;
};

/// Where something was found.
struct Place {
  std::size_t frame = 0;
  std::string view{};  ///< empty: it is about the whole film
  Region region{};     ///< in the view's pixels
  std::string body{};  ///< under it; empty: none is known
};

/// What one gate said.
struct GateResult {
  Gate gate{};
  bool passed = true;
  double worst = 0;                 ///< of all it looked at
  double limit = 0;                 ///< the largest that passes
  std::optional<Place> worst_at{};  ///< nothing when nothing differs
  std::optional<Place> first{};     ///< where it failed first; nothing when it passed
};

enum class Verdict : std::uint8_t {
  kSame,              ///< states and frames are approved ones
  kRenderingOnly,     ///< approved states, other bits in the frames, the same to the eye
  kStatesOnly,        ///< other states, the same to the eye
  kRenderingChanged,  ///< approved states; pictures differ
  kPhysicsChanged,    ///< other states; pictures differ
};

/// What came of a case.
struct Comparison {
  Verdict verdict = Verdict::kSame;
  std::array<GateResult, kGates> gates{};  ///< in the order of Gate

  /// Whether every gate but the first two passed.
  [[nodiscard]] bool passed() const noexcept {
    return verdict != Verdict::kRenderingChanged && verdict != Verdict::kPhysicsChanged;
  }
  /// Of the gates that failed, the one that did so at the first frame; of those one that names a
  /// body of the run, if there is one; of those the first in order.
  /// @returns null when all passed.
  [[nodiscard]] const GateResult* FirstFailure() const noexcept;
};

/// A verdict in a sentence, with first frame, region, body and gate: for people.
[[nodiscard]] std::string Describe(const Comparison& comparison, const Pictures& pictures);

/// What the other side of a comparison needs.
struct Evidence {
  const Pictures* pictures = nullptr;  ///< of the run
  std::uint64_t states = 0;            ///< hash of the run's states
  /// Gives the bodies of any frame of a view (by place), as the film numbers them: asked for the
  /// first frame whose signature is off, when that is no key picture. May be empty.
  std::function<render::SegmentationImage(std::size_t view, std::size_t frame)> look;
};

/// Compares a run's pictures with the approved ones. Bodies are compared by name.
/// @param ffmpeg  as render::VideoSettings::ffmpeg.
/// @throws InputError when they are not of the same views, sizes and interval: then nothing can be
/// compared; EnvironmentError as render::MeasureSsim.
[[nodiscard]] Comparison Compare(const Golden& golden, const Evidence& evidence,
                                 const Limits& limits = {},
                                 const std::filesystem::path& ffmpeg = "ffmpeg");

}  // namespace twin::golden
