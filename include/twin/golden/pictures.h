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

/// A view of a case and its drawing settings.
struct ViewPlan {
  std::string name;  ///< letters, digits, '_' and '-'; names its files
  render::FilmSettings settings;
};

/// Selection of a film's frames and views.
struct PicturePlan {
  std::size_t every = 1;       ///< stride of the selected frames, from the first on; >= 1
  std::size_t key_frames = 5;  ///< number of key frames, evenly spaced, with first and last; >= 2
  std::vector<ViewPlan> views;
};

/// Full data of one frame.
struct KeyPicture {
  std::size_t frame = 0;  ///< index among the selected frames
  render::Image colour;
  render::DepthImage depth;
  render::SegmentationImage bodies;  ///< indices into Pictures::bodies
};

/// Pictures of one view.
struct ViewPictures {
  std::string name;
  int width = 0;                            ///< pixels
  int height = 0;                           ///< pixels
  std::vector<std::uint64_t> hashes{};      ///< one per frame
  std::vector<render::Image> signatures{};  ///< one per frame
  std::vector<KeyPicture> keys{};           ///< ordered by frame
};

/// Appearance of a film, as stored in a golden.
struct Pictures {
  std::size_t frames = 0;
  double interval_s = 0;            ///< between frames
  std::vector<std::string> bodies;  ///< names, by the indices in KeyPicture
  std::vector<ViewPictures> views;
};

/// A hash of a picture's size and bytes. Not secure against an adversary.
[[nodiscard]] std::uint64_t HashOf(const render::Image& image);

/// @returns the selected frames' numbers in the film.
[[nodiscard]] std::vector<std::size_t> FramesOf(const render::Film& film, const PicturePlan& plan);

/// Draws the pictures of a film to store.
/// @param keys  frames of the key pictures (missing ones are skipped); nullopt: by the plan.
/// @param before_each  called before each picture; its exceptions propagate. May be empty.
/// @throws as render::FramePainter; InputError if the film has no frame, or a view is smaller than
/// a signature.
[[nodiscard]] Pictures TakePictures(const render::Film& film, const PicturePlan& plan,
                                    const std::optional<std::vector<std::size_t>>& keys = {},
                                    const std::function<void()>& before_each = {});

/// Changes the pictures' body numbers to another list of names, to which missing names are
/// appended.
void Relabel(Pictures& pictures, std::vector<std::string> names);

}  // namespace twin::golden
