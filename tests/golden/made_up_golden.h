#pragma once

#include <cstddef>
#include <cstdint>

#include "twin/golden/golden.h"
#include "twin/golden/signature.h"

namespace twin::golden {

/// Pictures of a grey film without a renderer: two views, `frames` frames, key pictures of the
/// first and the last.
inline Pictures GreyPictures(std::size_t frames = 5) {
  Pictures pictures{frames, 0.2, {"world", "link", "parcel"}, {}};
  for (const char* name : {"overview", "hand"}) {
    ViewPictures view{name, 64, 48};
    for (std::size_t i = 0; i < frames; ++i) {
      const auto level = static_cast<std::uint8_t>(100 + 20 * i);
      const render::Image picture(view.width, view.height, {level, 90, 80});
      view.hashes.push_back(HashOf(picture));
      view.signatures.push_back(SignatureOf(picture));
      if (i != 0 && i + 1 != frames) continue;
      KeyPicture key{i, picture, {64, 48, std::vector<float>(64 * 48, 1.5F)}, {64, 48, {}}};
      for (int pixel = 0; pixel < 64 * 48; ++pixel)
        key.bodies.body.push_back(pixel % 64 < 32 ? 0 : 1);
      view.keys.push_back(key);
    }
    pictures.views.push_back(view);
  }
  return pictures;
}

/// Pictures as they are approved, with the states' hash 7.
inline Golden GoldenOf(const Pictures& pictures) {
  Golden golden{pictures, {7}, {{}}, {{"made up", "all", "0"}}};
  for (ViewPictures& view : golden.pictures.views) {
    golden.renderings[0].push_back(view.hashes);
    view.hashes.clear();
  }
  return golden;
}

}  // namespace twin::golden
