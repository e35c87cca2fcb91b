#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace twin::model {

/// Whose figures a model library computes with.
enum class ModelFigures : std::uint8_t {
  kPanda,  ///< ArmModel::Panda(): what a real robot's library answers, and what INT computes with
  kPlant,  ///< ArmModel::PandaPlant(): the twin's own body, for who wants a client without model
           ///< error
};

/// A file larger than this some clients cannot load: libfranka-rs 0.9.0 waits forever for a reply
/// of some 300 KiB. Ours stay below.
inline constexpr std::size_t kLargestModelLibrary = std::size_t{64} << 10;

/// Finds the model library, which the robot hands to a client that asks for it and which the client
/// loads into its own process: a shared object with the 30 functions of FCI protocol 5, made of the
/// same sources as ArmModel (src/model/library). It is built for the machine the twin is built for.
/// Looked for, from the folder of the running program:
///   ../lib/panda-twin/   (installed)
///   lib/panda-twin/      (build folder)
/// @param program  path of the running program.
/// @throws EnvironmentError when it is in neither, with both names and what to do.
[[nodiscard]] std::filesystem::path FindModelLibrary(const std::filesystem::path& program,
                                                     ModelFigures figures = ModelFigures::kPanda);

/// @returns the file's bytes, as the answer to a client carries them.
/// @throws EnvironmentError when it cannot be read, is no shared object, or is larger than
/// kLargestModelLibrary.
[[nodiscard]] std::vector<std::byte> ReadModelLibrary(const std::filesystem::path& file);

}  // namespace twin::model
