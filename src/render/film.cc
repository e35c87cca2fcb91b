#include "twin/render/film.h"

#include <algorithm>
#include <cstddef>

#include "twin/core/error.h"

namespace twin::render {

void View::Validate() const {
  RequireInRange("render: view's turn (degrees per second)", turn_deg_per_s, -360, 360);
  if (kind != ViewKind::kOrbit && kind != ViewKind::kTracking) return;
  orbit.Validate("view's");
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
    RequireInRange("render: inset's share of the picture", inset.share, 0.1, 0.5);
  }
  RequireInRange("render: trace (s)", trace_s, 0.1, 1e4);
  RequireInRange("render: length of an arrow (m/N)", newton_m, 1e-6, 1);
}

}  // namespace twin::render
