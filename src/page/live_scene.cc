#include "page/live_scene.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "page/message.h"
#include "twin/core/hash.h"

namespace twin::page {
namespace {

std::string PathOf(const std::string& file) {
  WordHash hash;
  for (std::size_t at = 0; at < file.size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, file.data() + at, std::min(sizeof word, file.size() - at));
    hash.AddWord(word);
  }
  return "/scene/" + FormatHash(hash.value());
}

std::string ViewText(const render::View& view) {
  using render::ViewKind;
  const bool orbits = view.kind == ViewKind::kOrbit || view.kind == ViewKind::kTracking;
  const render::FreeCamera camera = orbits ? view.orbit : render::FreeCamera();
  const std::string lookat = view.kind == ViewKind::kOrbit
                                 ? fmt::format("[{:.4g}]", fmt::join(camera.lookat_m, ","))
                                 : std::string("null");
  return fmt::format(R"({{"azimuth":{:.4g},"elevation":{:.4g},"distance":{:.4g},"lookat":{}}})",
                     camera.azimuth_deg, camera.elevation_deg, camera.distance_m, lookat);
}

}  // namespace

LiveScene::LiveScene(const mjModel_& model, Source newest, const render::View& view,
                     std::string_view note)
    : newest_(std::move(newest)),
      bodies_(model),
      file_(render::SceneShapes(model)),
      path_(PathOf(file_)),
      description_(fmt::format(R"({{"path":"{}","note":{},"view":{}}})", path_, Quoted(note),
                               ViewText(view))) {}

const std::string& LiveScene::Poses() {
  if (const std::optional<Placed> placed = newest_()) {
    poses_ =
        fmt::format(R"("t":{:.3f},"bodies":[{:.5g}])", ToSeconds(placed->at.time_since_epoch()),
                    fmt::join(bodies_.At(placed->qpos), ","));
  }
  return poses_;
}

}  // namespace twin::page
