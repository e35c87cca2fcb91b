#include "twin/scenario/base_section.h"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "scenario/quoted.h"
#include "scenario/section_writers.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"

namespace twin::scenario {
namespace {

void RequireFinite(std::string_view field, double value) {
  if (std::isfinite(value)) return;
  throw InputError(fmt::format("base.{}: {} is no finite value", field, value));
}

}  // namespace

void BaseSection::Validate() const {
  RequireFinite("start.x", start.x);
  RequireFinite("start.y", start.y);
  RequireFinite("start.yaw", start.yaw);
  Duration end{};
  for (std::size_t i = 0; i < drive.size(); ++i) {
    RequireFinite(fmt::format("drive[{}].v", i + 1), drive[i].twist.v);
    RequireFinite(fmt::format("drive[{}].w", i + 1), drive[i].twist.w);
    if (drive[i].span <= Duration::zero()) {
      throw InputError(fmt::format("base.drive[{}].for: {} s; it must be above 0", i + 1,
                                   ToSeconds(drive[i].span)));
    }
    if (drive[i].at < end) {
      throw InputError(
          fmt::format("base.drive[{}].at: {} s is before the end of the drive before it, {} s",
                      i + 1, ToSeconds(drive[i].at), ToSeconds(end)));
    }
    end = drive[i].at + drive[i].span;
  }
}

std::string BaseText(const BaseSection& base) {
  std::string text = fmt::format("base:\n  model: {}\n  start: {{x: {} m, y: {} m, yaw: {} rad}}\n",
                                 Quoted(base.model), FormatNumber(base.start.x),
                                 FormatNumber(base.start.y), FormatNumber(base.start.yaw));
  if (base.drive.empty()) return text;
  text += "  drive:\n";
  for (const DriveEvent& event : base.drive) {
    text += fmt::format("    - {{at: {}, for: {}, v: {} m/s, w: {} rad/s}}\n",
                        FormatDuration(event.at), FormatDuration(event.span),
                        FormatNumber(event.twist.v), FormatNumber(event.twist.w));
  }
  return text;
}

}  // namespace twin::scenario
