#include "twin/render/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "twin/core/error.h"

namespace twin::render {
namespace {

void CheckRange(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw InputError(
        fmt::format("render: {} is {}; it must be in [{}, {}]", field, value, low, high));
  }
}

}  // namespace

void View::Validate() const {
  CheckRange("view's turn (degrees per second)", turn_deg_per_s, -360, 360);
  if (kind != ViewKind::kOrbit && kind != ViewKind::kTracking) return;
  CheckRange("view's distance (m)", orbit.distance_m, 0.01, 1000);
  CheckRange("view's azimuth (degrees)", orbit.azimuth_deg, -360, 360);
  CheckRange("view's elevation (degrees)", orbit.elevation_deg, -90, 90);
  for (const double x : orbit.lookat_m) CheckRange("view's lookat (m)", x, -1e3, 1e3);
}

void FilmSettings::Validate() const {
  render.Validate();
  view.Validate();
  for (std::size_t i = 0; i < insets.size(); ++i) {
    const Inset& inset = insets[i];
    inset.view.Validate();
    const auto hides = [&](const Inset& other) { return other.corner == inset.corner; };
    if (std::any_of(insets.begin() + static_cast<std::ptrdiff_t>(i) + 1, insets.end(), hides)) {
      throw InputError("render: two insets in one corner, where one hides the other; move one");
    }
    CheckRange("inset's share of the picture", inset.share, 0.1, 0.5);
  }
  CheckRange("trace (s)", trace_s, 0.1, 1e4);
  CheckRange("length of an arrow (m/N)", newton_m, 1e-6, 1);
}

}  // namespace twin::render
