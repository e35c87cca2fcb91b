#include "page/live_camera.h"

#include <chrono>
#include <optional>
#include <utility>

#include "twin/core/error.h"
#include "twin/render/film.h"
#include "twin/render/jpeg.h"
#include "twin/render/scene_painter.h"
#include "twin/rt/host_time.h"
#include "twin/rt/thread_setup.h"

namespace twin::page {
namespace {

constexpr int kMostRate_hz = 25;
constexpr Duration kPeriod = Duration(std::chrono::seconds(1)) / kMostRate_hz;
constexpr int kQuality = 80;
constexpr Duration kLookAgain = std::chrono::milliseconds(5);
/// Period of redrawing an unchanged scene, for new clients.
constexpr Duration kStandingAgain = std::chrono::milliseconds(500);

render::FilmSettings SettingsOf(const render::View& view) {
  render::FilmSettings settings;
  settings.view = view;
  return settings;
}

}  // namespace

LiveCamera::LiveCamera(const mjModel_& model, rt::LatestValue<record::SceneRecord>& scenes,
                       std::vector<NamedView> views, Calls calls)
    : model_(model), scenes_(scenes), views_(std::move(views)), calls_(std::move(calls)) {
  TWIN_CHECK(!views_.empty());
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void LiveCamera::Choose(std::size_t view) noexcept {
  if (view < views_.size()) chosen_.store(view, std::memory_order_relaxed);
}

void LiveCamera::Run(const std::stop_token& stop) {
  try {
    // Cannot fail: any thread may raise its nice value.
    static_cast<void>(
        rt::SetUpThisThread({.name = "twin-camera", .nice = 10, .lock_memory = false}));
    Draw(stop);
  } catch (const Error& error) {
    calls_.failure(error.what());
  }
}

void LiveCamera::Draw(const std::stop_token& stop) {
  render::JpegEncoder encoder(kQuality);
  std::optional<render::ScenePainter> painter;
  std::size_t view = 0;
  Time drawn{};
  for (Time due = clock_.Now(); !stop.stop_requested(); rt::SleepUntil(clock_, due)) {
    const Time now = clock_.Now();
    due = now + kLookAgain;
    if (!wanted_.load(std::memory_order_relaxed)) continue;
    const bool is_new = scenes_.Refresh();
    const bool is_elsewhere = painter && view != chosen();
    if (!scenes_.has_value() || (!is_new && !is_elsewhere && now - drawn < kStandingAgain))
      continue;
    if (!painter || is_elsewhere) {
      view = chosen();
      painter.emplace(model_, scenes_.value(), SettingsOf(views_[view].view));
    }
    painter->Show(scenes_.value());
    calls_.picture(encoder.Encode(painter->Paint()));
    drawn = now;
    due = now + kPeriod;
  }
}

}  // namespace twin::page
