#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// One robot of a cell: the scenario it would run alone, at its place.
struct CellRobot {
  std::string name;  ///< letters, digits, '_' and '-'
  /// Its own keys, with the cell's scene, drive and `record`, and the cell's objects as they were
  /// drawn. Its name is "<cell>_<robot>"; its seed is its own key, or made of the cell's seed and
  /// the robot's name; no video.
  Scenario scenario;
  std::string where;  ///< "<file>:<line>"
};

/// Several robots in one scene: a scenario file with the key `robots`.
struct Cell {
  /// Name, description, seed, drive, scene, objects, render and record; the rest is of no meaning.
  Scenario common;
  std::vector<CellRobot> robots;  ///< at least one, in the order of their names
};

/// Bases nearer to each other, m, would overlap: the foot of a Panda is 0.19 m wide. Decision.
inline constexpr double kLeastBaseDistance = 0.2;

/// Whether a file has the key `robots`. @throws InputError as Load, of a file that is no YAML.
[[nodiscard]] bool HasRobots(const std::filesystem::path& path);

/// Reads and validates a file with the key `robots`.
/// @param seed  in place of the file's.
/// @throws InputError as Load; also for keys of one robot beside `robots`, for bases that overlap,
/// and for clocks that drift apart.
[[nodiscard]] Cell LoadCell(const std::filesystem::path& path,
                            std::optional<std::uint64_t> seed = {});
/// As LoadCell, of robots that clients move, as LoadServed.
[[nodiscard]] Cell LoadServedCell(const std::filesystem::path& path,
                                  std::optional<std::uint64_t> seed = {});
/// As LoadCell, from text. @param file  as Parse's.
[[nodiscard]] Cell ParseCell(const std::string& text, const std::filesystem::path& file);
/// As LoadServedCell, from text.
[[nodiscard]] Cell ParseServedCell(const std::string& text, const std::filesystem::path& file,
                                   std::optional<std::uint64_t> seed = {});

/// The seed of a robot that names none.
[[nodiscard]] std::uint64_t SeedOf(std::uint64_t cell_seed, std::string_view robot) noexcept;

/// As of a scenario.
[[nodiscard]] std::string ToYaml(const Cell& cell);

}  // namespace twin::scenario
