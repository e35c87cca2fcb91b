#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "twin/render/film.h"
#include "twin/render/image.h"

namespace twin::golden {

/// A view of a case: how its pictures are made.
struct ViewPlan {
  std::string name;  ///< letters, digits, '_' and '-'; names its files
  render::FilmSettings settings;
};

/// Which frames of a film are looked at, from where.
struct PicturePlan {
  std::size_t every = 1;       ///< only each so many frames of the film, from the first on; >= 1
  std::size_t key_frames = 5;  ///< of those, evenly spaced, first and last included; >= 2
  std::vector<ViewPlan> views;
};

/// All that is kept of one frame.
struct KeyPicture {
  std::size_t frame = 0;  ///< among those that are looked at
  render::Image colour;
  render::DepthImage depth;
  render::SegmentationImage bodies;  ///< places in Pictures::bodies
};

/// What is kept of a view.
struct ViewPictures {
  std::string name;
  int width = 0;                            ///< pixels
  int height = 0;                           ///< pixels
  std::vector<std::uint64_t> hashes{};      ///< of each frame
  std::vector<render::Image> signatures{};  ///< of each frame
  std::vector<KeyPicture> keys{};           ///< by frame, rising
};

/// What a film looked like, as a golden keeps it.
struct Pictures {
  std::size_t frames = 0;
  double interval_s = 0;            ///< from one to the next
  std::vector<std::string> bodies;  ///< names, by what a KeyPicture's pixels say
  std::vector<ViewPictures> views;
};

/// A fingerprint of a picture's size and bytes. No defence against an adversary.
[[nodiscard]] std::uint64_t HashOf(const render::Image& image);

/// @returns the numbers, in the film, of the frames that are looked at.
[[nodiscard]] std::vector<std::size_t> FramesOf(const render::Film& film, const PicturePlan& plan);

/// Draws what is to be kept of a film.
/// @param keys  which frames are key pictures (those that there are); absent: by the plan.
/// @param before_each  is called before each picture; what it throws is thrown on. May be empty.
/// @throws as render::FramePainter; InputError when the film has no frame, or a view is smaller
/// than a signature.
[[nodiscard]] Pictures TakePictures(const render::Film& film, const PicturePlan& plan,
                                    const std::optional<std::vector<std::size_t>>& keys = {},
                                    const std::function<void()>& before_each = {});

/// The same pictures of bodies, told by another list of names: what it lacks is appended to it.
void Relabel(Pictures& pictures, std::vector<std::string> names);

}  // namespace twin::golden
