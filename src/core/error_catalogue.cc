#include "twin/core/error_catalogue.h"

#include <fmt/format.h>

#include "core/error_entries.h"
#include "twin/core/error.h"

namespace twin {
namespace {

constexpr std::array<std::string_view, 3> kMotionAxes{"translation", "rotation", "elbow"};
constexpr std::array<std::string_view, 6> kWrenchAxes{"x of K", "y of K", "z of K",
                                                      "R of K", "P of K", "Y of K"};

/// Name of an entry's axes in the catalogue.
std::string_view AxesOf(const ErrorEntry& entry) {
  switch (entry.axis) {
    case AxisKind::kJoint: return "a joint";
    case AxisKind::kMotion: return "translation, rotation or elbow";
    case AxisKind::kWrench: return "an axis of K: x y z R P Y";
    case AxisKind::kNone: break;
  }
  return "";
}

/// "m/s, rad/s, rad/s"; one unit if kMotion has one for all.
std::string UnitsOf(const ErrorEntry& entry) {
  std::string text;
  for (const std::string_view unit : entry.units) {
    if (unit.empty() || text == unit) continue;
    if (!text.empty()) text += ", ";
    text += unit;
  }
  return text;
}

void AddLine(std::string& text, std::string_view label, std::string_view words) {
  if (!words.empty()) text += fmt::format("- {}: {}.\n", label, words);
}

void AddEntry(std::string& text, const ErrorEntry& entry) {
  text += fmt::format("{}.\n\n", entry.meaning);
  if (!entry.raised) {
    AddLine(text, "not raised here", entry.cause);
    return;
  }
  std::string compared(entry.quantity);
  const std::string units = UnitsOf(entry);
  if (!units.empty()) compared += fmt::format(" ({})", units);
  const std::string_view axes = AxesOf(entry);
  if (!axes.empty()) compared += fmt::format(", of {}", axes);
  AddLine(text, "compared", compared);
  AddLine(text, "computed", entry.computed);
  AddLine(text, "usual cause", entry.cause);
  AddLine(text, "cure", entry.cure);
  AddLine(text, "in a scenario", entry.in_scenario);
  if (entry.in_realtime != entry.in_scenario) AddLine(text, "in real time", entry.in_realtime);
}

}  // namespace

const ErrorEntry& EntryOf(RobotError error) noexcept {
  TWIN_CHECK(static_cast<std::size_t>(error) < kErrorEntries.size());
  return kErrorEntries[static_cast<std::size_t>(error)];
}

const ErrorEntry& EntryOf(const Violation& violation) noexcept {
  for (const OtherCause& cause : kOtherCauses) {
    if (violation.error == cause.error && violation.axis == cause.axis) return cause.entry;
  }
  return EntryOf(violation.error);
}

std::string AxisName(const Violation& violation) {
  if (violation.axis < 0) return "";
  const auto axis = static_cast<std::uint8_t>(violation.axis);
  switch (EntryOf(violation).axis) {
    case AxisKind::kJoint: return fmt::format("joint {}", axis + 1);
    case AxisKind::kMotion: return axis < kMotionAxes.size() ? std::string(kMotionAxes[axis]) : "";
    case AxisKind::kWrench: return axis < kWrenchAxes.size() ? std::string(kWrenchAxes[axis]) : "";
    case AxisKind::kNone: break;
  }
  return "";
}

std::string_view UnitOf(const Violation& violation) noexcept {
  const ErrorEntry& entry = EntryOf(violation);
  const auto axis = static_cast<std::size_t>(violation.axis < 0 ? 0 : violation.axis);
  switch (entry.axis) {
    case AxisKind::kMotion: return axis < entry.units.size() ? entry.units[axis] : "";
    case AxisKind::kWrench: return entry.units[axis < 3 ? 0 : 1];
    case AxisKind::kJoint:
    case AxisKind::kNone: break;
  }
  return entry.units[0];
}

std::string_view CureHere(const ErrorEntry& entry, TimeKeeper keeper) noexcept {
  const std::string_view here =
      keeper == TimeKeeper::kWallClock ? entry.in_realtime : entry.in_scenario;
  return here.empty() ? entry.cure : here;
}

std::string CureOf(const ErrorEntry& entry, TimeKeeper keeper) {
  const std::string_view here = CureHere(entry, keeper);
  return here == entry.cure ? std::string(here) : fmt::format("{}. Here: {}", entry.cure, here);
}

std::string ErrorCatalogue() {
  std::string text =
      "# The errors of the robot's controller\n\n"
      "Numbers and names are those of the robot state (FCI protocol 5). q_d, dq_d, ddq_d, "
      "O_dP_EE_c and so on are the values that the last state reports, those of the cycle before. "
      "Limits are compared with a relative tolerance of 1e-9.\n";
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    const auto error = static_cast<RobotError>(i);
    text += fmt::format("\n## {} {}\n\n", i, Name(error));
    AddEntry(text, EntryOf(error));
    for (const OtherCause& cause : kOtherCauses) {
      if (cause.error != error) continue;
      text += "\nOr: ";
      AddEntry(text, cause.entry);
    }
  }
  return text;
}

}  // namespace twin
