#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace twin::model {

/// Parameters of a model library.
enum class ModelFigures : std::uint8_t {
  kPanda,  ///< ArmModel::Panda(): those of a real robot's library and of INT
  kPlant,  ///< ArmModel::PandaPlant(): those of the twin's plant, for a client without model error
};

/// Some clients cannot load a larger file: libfranka-rs 0.9.0 blocks forever on a reply of about
/// 300 KiB. Ours stay below this.
inline constexpr std::size_t kLargestModelLibrary = std::size_t{64} << 10;

/// Finds the model library, which the robot sends to a client for loading into its process: a
/// shared object with the 30 functions of FCI protocol 5, built from ArmModel's sources
/// (src/model/library) for the twin's platform. Searched relative to the folder of the running
/// program:
///   ../lib/panda-twin/   (installed)
///   lib/panda-twin/      (build folder)
/// @param program  path of the running program.
/// @throws EnvironmentError if neither has it, with both names and the remedy.
[[nodiscard]] std::filesystem::path FindModelLibrary(const std::filesystem::path& program,
                                                     ModelFigures figures = ModelFigures::kPanda);

/// @returns the file's bytes, as in the reply to a client.
/// @throws EnvironmentError if it is not readable, not a shared object, or larger than
/// kLargestModelLibrary.
[[nodiscard]] std::vector<std::byte> ReadModelLibrary(const std::filesystem::path& file);

}  // namespace twin::model
