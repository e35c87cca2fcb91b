#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "twin/application/partners.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"

namespace twin::application {

/// Whether a scenario's controller.library is loaded, which runs code of it.
enum class LibraryCheck : std::uint8_t { kNotLoaded, kLoaded };

/// Prepares all that a run prepares, so that a run does not refuse what passes here; runs no code
/// that the scenario names unless asked.
///
/// Threads: one thread. A motion that is planned is planned here too. @param file  of the
/// scenario, for messages. @returns what was checked, a line each.
/// @param partners  other robots of its cell; null: the robot is alone.
/// @throws as run::Run, ApplicationRun, replay::CheckPicture and run::RequireFree.
[[nodiscard]] std::string Validate(const scenario::Scenario& scenario,
                                   const std::filesystem::path& file,
                                   const run::Catalogue& catalogue, const run::RunFiles& files,
                                   LibraryCheck library = LibraryCheck::kNotLoaded,
                                   const Partners* partners = nullptr);

}  // namespace twin::application
