#include "twin/teleop/operator_script.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/csv_lines.h"
#include "twin/core/error.h"
#include "twin/core/quantity.h"
#include "twin/teleop/operator_ranges.h"

namespace twin::teleop {
namespace {

constexpr std::array<std::string_view, 16> kColumns{
    "time",    "kind", "x",       "y",     "z",     "rx",   "ry",      "rz",
    "engaged", "mode", "gripper", "frame", "scale", "stop", "release", "end"};
enum Column : std::size_t { kTime, kKind, kFirstAxis, kEngaged = 8, kFirstPress };
constexpr CsvFormat kFormat{
    kColumns, "time in s, kind rate, pose or joint1 to joint7, presses since the row before"};
constexpr double kLongestSeconds = 86400;
constexpr std::uint32_t kMostPresses = std::numeric_limits<std::uint32_t>::max();

double InRange(const CsvLines& lines, std::size_t column, std::string_view unit, double least,
               double most) {
  const double value = lines.Number(column, unit);
  if (value >= least && value <= most) return value;
  lines.Refuse(column, fmt::format("it must lie in [{}, {}] {}", least, most, unit));
}

/// 4 of "joint4"; 0 of other kinds.
std::uint8_t JointOf(const CsvLines& lines) {
  for (std::uint8_t joint = 1; joint <= kJoints; ++joint) {
    if (lines.field(kKind) == fmt::format("joint{}", joint)) return joint;
  }
  return 0;
}

AxisKind KindOf(const CsvLines& lines) {
  if (lines.field(kKind) == "rate") return AxisKind::kRate;
  if (lines.field(kKind) == "pose") return AxisKind::kPose;
  if (JointOf(lines) != 0) return AxisKind::kRate;
  lines.Refuse(kKind, "it must be rate, pose or joint1 to joint7");
}

bool FlagOf(const CsvLines& lines, std::size_t column) {
  if (lines.field(column) == "1") return true;
  if (lines.field(column) == "0") return false;
  lines.Refuse(column, "it must be 1 or 0");
}

std::uint32_t PressesOf(const CsvLines& lines, std::size_t column) {
  const double presses = InRange(lines, column, "presses", 0, kMostPresses);
  if (presses == std::floor(presses)) return static_cast<std::uint32_t>(presses);
  lines.Refuse(column, "it must be a whole number of presses");
}

OperatorSample SampleOf(const CsvLines& lines, const OperatorSample& before) {
  OperatorSample sample = before;
  ++sample.sequence;
  sample.at = Time(FromSeconds(InRange(lines, kTime, "seconds", 0, kLongestSeconds)));
  if (before.sequence > 0 && sample.at <= before.at) {
    lines.Refuse(kTime, "it must be later than that of the line before");
  }
  sample.kind = KindOf(lines);
  sample.joint = JointOf(lines);
  const double most = MostOfAxis(sample.kind);
  const std::string_view unit = sample.kind == AxisKind::kRate ? "of full scale" : "m or rad";
  for (std::size_t i = 0; i < sample.axes.size(); ++i) {
    sample.axes[i] = InRange(lines, kFirstAxis + i, unit, -most, most);
  }
  sample.engaged = FlagOf(lines, kEngaged);
  for (std::size_t i = 0; i < kPresses.size(); ++i) {
    const std::uint32_t presses = PressesOf(lines, kFirstPress + i);
    if (presses > kMostPresses - sample.*kPresses[i]) {
      lines.Refuse(
          kFirstPress + i,
          fmt::format("with those of the lines before it must be at most {}", kMostPresses));
    }
    sample.*kPresses[i] += presses;
  }
  return sample;
}

}  // namespace

std::vector<OperatorSample> ReadOperatorScript(std::istream& in, const std::string& name) {
  CsvLines lines(in, name, kFormat);
  std::vector<OperatorSample> samples;
  while (lines.Next()) {
    samples.push_back(SampleOf(lines, samples.empty() ? OperatorSample{} : samples.back()));
  }
  if (!samples.empty()) return samples;
  throw InputError(fmt::format("{}: no samples; wanted is the header '{}' and a row for each", name,
                               fmt::join(kColumns, ",")));
}

std::vector<OperatorSample> ReadOperatorScript(const std::filesystem::path& path) {
  std::ifstream file = OpenTextFile(path, kMostScriptBytes, "an operator's script");
  return ReadOperatorScript(file, path.filename().string());
}

std::string OperatorScriptHeader() {
  return fmt::format("{}\n", fmt::join(kColumns, ","));
}

std::string OperatorScriptRow(const OperatorSample& sample, const OperatorSample& before) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = sample.at.time_since_epoch().count();
  std::string kind = sample.kind == AxisKind::kRate ? "rate" : "pose";
  if (sample.joint != 0) kind = fmt::format("joint{}", sample.joint);
  std::string row = fmt::format("{}.{:09},{}", ns / kSecond, ns % kSecond, kind);
  for (const double axis : sample.axes) row += ',' + FormatNumber(axis);
  row += sample.engaged ? ",1" : ",0";
  for (const auto presses : kPresses) {
    row += fmt::format(",{}", sample.*presses - before.*presses);
  }
  return row + '\n';
}

}  // namespace twin::teleop
