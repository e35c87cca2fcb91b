#include "twin/golden/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "golden/golden_files.h"
#include "twin/core/error.h"
#include "twin/golden/signature.h"
#include "twin/render/image_operations.h"

namespace twin::golden {
namespace {

struct Words {
  std::string_view name;
  std::string_view meaning;
};
constexpr std::array<Words, kGates> kWords{
    {{"states", "hash of all states: 1 when no approved one"},
     {"hashes", "frames without an approved hash"},
     {"frames", "frames too few or too many"},
     {"signatures", "every frame at 32 x 24: levels of the channel most off"},
     {"colours", "key pictures: channels off by more than 1 of 255 (scenery: 5), %"},
     {"colour window", "pixels off by more than 2 of 255 (scenery: 5), in the fullest window"},
     {"depths", "pixels whose depth is off by more than 1 mm, %"},
     {"depth window", "pixels whose depth is off, in the fullest window"},
     {"bodies", "pixels that show another body, %"},
     {"body window", "pixels that show another body, in the fullest window"},
     {"ssim", "1 - structural similarity"}}};

constexpr double kPercent = 100;

/// The first gate that can fail a case.
constexpr std::size_t kDeciding = static_cast<std::size_t>(Gate::kFrames);

/// Collects the gates' results during one comparison.
class Gates {
 public:
  explicit Gates(const Limits& limits) {
    const double window = limits.window_pixels;
    const std::array<double, kGates> most{0,
                                          0,
                                          0,
                                          double(limits.signature_levels),
                                          limits.colour_percent,
                                          window,
                                          limits.depth_percent,
                                          window,
                                          limits.body_percent,
                                          window,
                                          limits.dissimilarity};
    for (std::size_t i = 0; i < kGates; ++i) {
      results_[i].gate = static_cast<Gate>(i);
      results_[i].limit = most[i];
    }
  }

  /// Adds a measurement. Keeps the failure with the earliest frame.
  void Take(Gate gate, double value, const Place& place) {
    GateResult& result = results_[static_cast<std::size_t>(gate)];
    if (value > result.worst) {
      result.worst = value;
      result.worst_at = place;
    }
    if (value <= result.limit) return;
    result.passed = false;
    if (!result.first || place.frame < result.first->frame) result.first = place;
  }

  [[nodiscard]] GateResult& Of(Gate gate) { return results_[static_cast<std::size_t>(gate)]; }
  [[nodiscard]] const std::array<GateResult, kGates>& results() const { return results_; }

 private:
  std::array<GateResult, kGates> results_{};
};

[[noreturn]] void FailFit(const std::string& what) {
  throw InputError(
      fmt::format("{}. The case was changed after its golden was approved: look at "
                  "its pictures, and approve it anew",
                  what));
}

std::string SizeOf(const ViewPictures& view) {
  return fmt::format("{} ({} x {})", view.name, view.width, view.height);
}

void RequireFit(const Pictures& expected, const Pictures& actual) {
  const auto list = [](const Pictures& pictures) {
    std::string text;
    for (const ViewPictures& view : pictures.views) {
      text += (text.empty() ? "" : ", ") + SizeOf(view);
    }
    return text;
  };
  if (list(expected) != list(actual)) {
    FailFit(fmt::format("the golden has the views {}, the case {}", list(expected), list(actual)));
  }
  if (std::abs(expected.interval_s - actual.interval_s) > 1e-9) {
    FailFit(fmt::format("the golden has a frame each {} s, the case each {} s", expected.interval_s,
                        actual.interval_s));
  }
}

/// @returns null if the frame is not a key picture.
const KeyPicture* KeyOf(const ViewPictures& view, std::size_t frame) {
  const auto found = std::find_if(view.keys.begin(), view.keys.end(),
                                  [&](const KeyPicture& key) { return key.frame == frame; });
  return found == view.keys.end() ? nullptr : &*found;
}

/// The name of BodyUnder(); empty for the background.
std::string BodyIn(const render::SegmentationImage& expected,
                   const render::SegmentationImage& actual, const Region& region,
                   const std::vector<std::string>& names) {
  const std::int32_t body = BodyUnder(expected, actual, region);
  return body < 0 ? std::string() : names[static_cast<std::size_t>(body)];
}

/// Compares one run with one golden.
class Comparer {
 public:
  Comparer(const Golden& golden, const Evidence& evidence, const Limits& limits,
           std::filesystem::path ffmpeg)
      : golden_(golden),
        evidence_(evidence),
        actual_(*evidence.pictures),
        limits_(limits),
        ffmpeg_(std::move(ffmpeg)),
        gates_(limits) {
    Relabel(actual_, golden.pictures.bodies);
  }

  Comparison Run() {
    CompareHashes();
    for (std::size_t view = 0; view < actual_.views.size(); ++view) {
      CompareFrames(view);
      CompareKeys(view);
    }
    NameBody();
    return {VerdictOf(), gates_.results()};
  }

 private:
  [[nodiscard]] const ViewPictures& Expected(std::size_t view) const {
    return golden_.pictures.views[view];
  }

  [[nodiscard]] bool IsApproved(std::size_t view, std::size_t frame) const {
    return std::any_of(golden_.renderings.begin(), golden_.renderings.end(),
                       [&](const Rendering& hashes) {
                         return frame < hashes[view].size() &&
                                hashes[view][frame] == actual_.views[view].hashes[frame];
                       });
  }

  void CompareHashes() {
    const auto& states = golden_.states;
    const bool known = std::find(states.begin(), states.end(), evidence_.states) != states.end();
    gates_.Take(Gate::kStates, known ? 0 : 1, {});
    double unknown = 0;
    for (std::size_t frame = 0; frame < actual_.frames; ++frame) {
      for (std::size_t view = 0; view < actual_.views.size(); ++view) {
        if (IsApproved(view, frame)) continue;
        gates_.Take(Gate::kHashes, ++unknown, {frame, actual_.views[view].name});
      }
    }
    const std::size_t expected = golden_.pictures.frames;
    const std::size_t common = std::min(expected, actual_.frames);
    gates_.Take(Gate::kFrames, static_cast<double>(std::max(expected, actual_.frames) - common),
                {common});
  }

  void CompareFrames(std::size_t view) {
    const ViewPictures& expected = Expected(view);
    const ViewPictures& actual = actual_.views[view];
    const std::size_t frames = std::min(golden_.pictures.frames, actual_.frames);
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const SignatureDifference off =
          CompareSignatures(expected.signatures[frame], actual.signatures[frame]);
      const int left = off.column * actual.width / kSignatureWidth;
      const int top = off.row * actual.height / kSignatureHeight;
      const Region region{left, top, (off.column + 1) * actual.width / kSignatureWidth - left,
                          (off.row + 1) * actual.height / kSignatureHeight - top};
      gates_.Take(Gate::kSignatures, off.levels, {frame, actual.name, region});
    }
  }

  void CompareKeys(std::size_t view) {
    std::vector<render::Image> expected;
    std::vector<render::Image> actual;
    std::vector<std::size_t> frames;
    for (const KeyPicture& before : Expected(view).keys) {
      const KeyPicture* after = KeyOf(actual_.views[view], before.frame);
      if (after == nullptr) continue;  // the film ends earlier: the gate of frames reports it
      CompareKey(actual_.views[view].name, before, *after);
      expected.push_back(before.colour);
      actual.push_back(after->colour);
      frames.push_back(before.frame);
    }
    const std::vector<double> ssim = render::MeasureSsim(expected, actual, ffmpeg_);
    for (std::size_t i = 0; i < ssim.size(); ++i) {
      gates_.Take(Gate::kSsim, 1 - ssim[i], {frames[i], actual_.views[view].name});
    }
  }

  void CompareKey(const std::string& view, const KeyPicture& before, const KeyPicture& after) {
    const auto take = [&](Gate share, Gate window, const Difference& difference) {
      Place place{before.frame, view, difference.region};
      place.body = BodyIn(before.bodies, after.bodies, difference.region, actual_.bodies);
      gates_.Take(share, kPercent * difference.share, place);
      gates_.Take(window, difference.window_pixels, place);
    };
    take(Gate::kColours, Gate::kColourWindow,
         CompareColours(before.colour, after.colour, SceneryOf(before.bodies, after.bodies),
                        limits_.colour, limits_.window_px));
    take(Gate::kDepths, Gate::kDepthWindow,
         CompareDepths(before.depth, RoundedDepths(after.depth), limits_.depth_m,
                       limits_.window_px));
    take(Gate::kBodies, Gate::kBodyWindow,
         CompareBodies(before.bodies, after.bodies, limits_.window_px));
  }

  /// Adds the body to the signatures' failure, which has only a position.
  void NameBody() {
    auto& first = gates_.Of(Gate::kSignatures).first;
    if (!first) return;
    const auto view = static_cast<std::size_t>(
        std::find_if(actual_.views.begin(), actual_.views.end(),
                     [&](const ViewPictures& other) { return other.name == first->view; }) -
        actual_.views.begin());
    const KeyPicture* before = KeyOf(Expected(view), first->frame);
    const KeyPicture* after = KeyOf(actual_.views[view], first->frame);
    if (before != nullptr && after != nullptr) {
      first->body = BodyIn(before->bodies, after->bodies, first->region, actual_.bodies);
    } else if (evidence_.look) {
      const render::SegmentationImage bodies = evidence_.look(view, first->frame);
      first->body = BodyIn(bodies, bodies, first->region, evidence_.pictures->bodies);
    }
  }

  [[nodiscard]] Verdict VerdictOf() {
    const auto& gates = gates_.results();
    const bool looks_the_same = std::all_of(gates.begin() + kDeciding, gates.end(),
                                            [](const GateResult& gate) { return gate.passed; });
    const bool same_states = gates_.Of(Gate::kStates).passed;
    if (!looks_the_same) {
      return same_states ? Verdict::kRenderingChanged : Verdict::kPhysicsChanged;
    }
    if (!same_states) return Verdict::kStatesOnly;
    return gates_.Of(Gate::kHashes).passed ? Verdict::kSame : Verdict::kRenderingOnly;
  }

  const Golden& golden_;
  const Evidence& evidence_;
  Pictures actual_;
  Limits limits_;
  std::filesystem::path ffmpeg_;
  Gates gates_;
};

std::string_view TextOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kSame: return "the same, bit by bit";
    case Verdict::kRenderingOnly:
      return "rendering only: the states are approved ones and the pictures look the same, but "
             "their bits differ";
    case Verdict::kStatesOnly:
      return "the states differ from those approved, and the pictures look the same";
    case Verdict::kRenderingChanged:
      return "the rendering changed: the states are approved ones, the pictures are not";
    case Verdict::kPhysicsChanged: return "the physics changed, and the pictures with it";
  }
  return "";
}

}  // namespace

std::string_view Name(Gate gate) noexcept {
  return kWords[static_cast<std::size_t>(gate)].name;
}

std::string_view Meaning(Gate gate) noexcept {
  return kWords[static_cast<std::size_t>(gate)].meaning;
}

const GateResult* Comparison::FirstFailure() const noexcept {
  // Ranks the gates of one frame by the detail of their result.
  const auto rank = [](const GateResult& gate) {
    const Place& place = *gate.first;
    return std::pair(place.frame, place.body.empty() ? 2 : place.body == "world" ? 1 : 0);
  };
  const GateResult* first = nullptr;
  for (std::size_t i = kDeciding; i < kGates; ++i) {
    const GateResult& gate = gates[i];
    if (gate.first && (first == nullptr || rank(gate) < rank(*first))) first = &gate;
  }
  return first;
}

std::string Describe(const Comparison& comparison, const Pictures& pictures) {
  std::string text(TextOf(comparison.verdict));
  const GateResult* failure = comparison.FirstFailure();
  if (failure == nullptr) return text;
  const Place& place = *failure->first;
  text += fmt::format("; first at frame {} ({:.2f} s)", place.frame,
                      static_cast<double>(place.frame) * pictures.interval_s);
  if (!place.view.empty()) text += fmt::format(", view {}", place.view);
  if (place.region.width > 0) {
    text += fmt::format(", pixels ({}, {}) to ({}, {})", place.region.left, place.region.top,
                        place.region.left + place.region.width - 1,
                        place.region.top + place.region.height - 1);
  }
  if (!place.body.empty()) text += fmt::format(", on {}", place.body);
  return text + fmt::format(", by the gate of {} ({:.4g}, at most {:.4g})", Name(failure->gate),
                            failure->worst, failure->limit);
}

Comparison Compare(const Golden& golden, const Evidence& evidence, const Limits& limits,
                   const std::filesystem::path& ffmpeg) {
  TWIN_CHECK(evidence.pictures != nullptr);
  RequireFit(golden.pictures, *evidence.pictures);
  return Comparer(golden, evidence, limits, ffmpeg).Run();
}

}  // namespace twin::golden
