#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string_view>

namespace twin::plant {

/// Compiled models that a cache keeps: those used last.
inline constexpr std::size_t kMostCachedModels = 64;

/// Makes a folder fit to keep compiled models (MujocoPlantOptions::cache): makes it, tries that it
/// can be written to, removes models that are damaged, and of the others, unfinished ones included,
/// all but the kMostCachedModels used last. What else is in it stays.
/// Reads all of them: 13 models of 12 MB in 5 ms.
/// @param note  gets what is wrong, for people.
/// @returns whether it can be used. Threads: one; several processes may share a folder.
[[nodiscard]] bool RepairModelCache(const std::filesystem::path& folder,
                                    const std::function<void(std::string_view)>& note);

}  // namespace twin::plant
