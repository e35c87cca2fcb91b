#pragma once

#include <cstdint>
#include <filesystem>

#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// Whether the world of this seed is an application that comes with the program: one of 128.
[[nodiscard]] bool IsApplicationWorld(std::uint64_t seed);

/// That world: one of the applications, teleoperation by a scripted person on a mobile base among
/// them; one of two is led by people at an operator's page (page_people.h).
/// @param models  the folder of models.
[[nodiscard]] scenario::Scenario DrawApplicationWorld(std::uint64_t seed,
                                                      const std::filesystem::path& models);

/// An application with objects, noise and person of another seed, and with the links, clocks,
/// computation times and, if it has none of its own, pushes that any world has. It may fail, but
/// never in silence.
[[nodiscard]] scenario::Scenario DrawAround(std::uint64_t seed, scenario::Scenario application);

}  // namespace twin::campaign
