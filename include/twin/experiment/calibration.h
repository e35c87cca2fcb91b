#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "twin/loop/loop_config.h"

namespace twin::experiment {

/// One of the paper's three loops.
struct CalibratedLoop {
  std::string_view name;  ///< the paper's: "LF"
  std::string_view file;  ///< its scenario, without .yaml
  loop::LoopKind kind{};  ///< the loop that the scenario must name
};

// Places in CalibratedLoops().
inline constexpr std::size_t kBare = 0;
inline constexpr std::size_t kSynchronous = 1;
inline constexpr std::size_t kAsynchronous = 2;

/// LF, RS, RA, in the paper's order.
[[nodiscard]] const std::array<CalibratedLoop, 3>& CalibratedLoops() noexcept;

/// Source of the delays of every experiment.
struct Calibration {
  /// 16 hexadecimal digits: FNV-1a over the three scenarios as ToYaml writes them. It changes with
  /// any of their values.
  std::string hash;
  std::array<std::string, 3> yaml;  ///< of the loops, complete
};

/// @param scenarios  Config::scenarios. @throws InputError as scenario::Load.
[[nodiscard]] Calibration ReadCalibration(const std::filesystem::path& scenarios);

}  // namespace twin::experiment
