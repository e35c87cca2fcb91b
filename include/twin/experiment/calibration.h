#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "twin/loop/loop_config.h"

namespace twin::experiment {

/// One of the paper's three loops.
struct CalibratedLoop {
  std::string_view name;  ///< as the paper has it: "LF"
  std::string_view file;  ///< its scenario, without .yaml
  loop::LoopKind kind{};  ///< what its scenario must say
};

/// LF, RS, RA, in the paper's order.
[[nodiscard]] const std::array<CalibratedLoop, 3>& CalibratedLoops() noexcept;

/// What every experiment takes its delays from.
struct Calibration {
  /// 16 hexadecimal digits: FNV-1a over the three scenarios as ToYaml writes them. Another one
  /// means that something in them is another.
  std::string hash;
  std::array<std::string, 3> yaml;  ///< of the loops, complete
};

/// @param scenarios  Setting::scenarios. @throws InputError as scenario::Load.
[[nodiscard]] Calibration ReadCalibration(const std::filesystem::path& scenarios);

}  // namespace twin::experiment
