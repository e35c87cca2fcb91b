#include "twin/golden/pictures.h"

#include <algorithm>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/golden/signature.h"
#include "twin/render/frame_painter.h"
#include "twin/render/image_operations.h"
#include "twin/render/renderer.h"

namespace twin::golden {
namespace {

void RequireRoom(const ViewPlan& view) {
  const render::RenderSettings& size = view.settings.render;
  if (size.width >= kSignatureWidth && size.height >= kSignatureHeight) return;
  throw InputError(fmt::format("view {} is of {} x {} pixels; goldens need at least {} x {}",
                               view.name, size.width, size.height, kSignatureWidth,
                               kSignatureHeight));
}

ViewPictures TakeView(const render::Film& film, const ViewPlan& plan,
                      const std::vector<std::size_t>& frames, const std::vector<std::size_t>& keys,
                      const std::function<void()>& before_each) {
  RequireRoom(plan);
  render::FramePainter painter(film, plan.settings);
  ViewPictures view{plan.name, plan.settings.render.width, plan.settings.render.height};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (before_each) before_each();
    render::Image picture = painter.Paint(frames[i]);
    view.hashes.push_back(HashOf(picture));
    view.signatures.push_back(SignatureOf(picture));
    if (std::find(keys.begin(), keys.end(), i) == keys.end()) continue;
    view.keys.push_back(
        {i, std::move(picture), painter.Depth(frames[i]), painter.Segment(frames[i])});
  }
  return view;
}

}  // namespace

std::uint64_t HashOf(const render::Image& image) {
  // FNV-1a, byte by byte.
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&hash](std::uint8_t byte) { hash = (hash ^ byte) * 0x100000001b3; };
  for (const int length : {image.width, image.height}) {
    for (int shift = 0; shift < 32; shift += 8) add(static_cast<std::uint8_t>(length >> shift));
  }
  for (const std::uint8_t byte : image.rgb) add(byte);
  return hash;
}

std::vector<std::size_t> FramesOf(const render::Film& film, const PicturePlan& plan) {
  TWIN_CHECK(plan.every >= 1);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < film.snapshots->size(); i += plan.every) frames.push_back(i);
  return frames;
}

Pictures TakePictures(const render::Film& film, const PicturePlan& plan,
                      const std::optional<std::vector<std::size_t>>& keys,
                      const std::function<void()>& before_each) {
  const std::vector<std::size_t> frames = FramesOf(film, plan);
  if (frames.empty()) throw InputError("the run has no frame that could be looked at");
  Pictures pictures;
  pictures.frames = frames.size();
  pictures.interval_s = static_cast<double>(plan.every) / film.snapshots->fps();
  pictures.bodies = render::BodyNames(*film.model);
  const auto key_frames = keys ? *keys : render::SpreadFrames(frames.size(), plan.key_frames);
  for (const ViewPlan& view : plan.views) {
    pictures.views.push_back(TakeView(film, view, frames, key_frames, before_each));
  }
  return pictures;
}

void Relabel(Pictures& pictures, std::vector<std::string> names) {
  std::vector<std::int32_t> there(pictures.bodies.size());
  for (std::size_t i = 0; i < there.size(); ++i) {
    auto found = std::find(names.begin(), names.end(), pictures.bodies[i]);
    if (found == names.end()) found = names.insert(names.end(), pictures.bodies[i]);
    there[i] = static_cast<std::int32_t>(found - names.begin());
  }
  for (ViewPictures& view : pictures.views) {
    for (KeyPicture& key : view.keys) {
      for (std::int32_t& body : key.bodies.body) {
        if (body >= 0) body = there[static_cast<std::size_t>(body)];
      }
    }
  }
  pictures.bodies = std::move(names);
}

}  // namespace twin::golden
