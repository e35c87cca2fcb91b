#pragma once

#include <string>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {

/// Calls `check`; puts the line `name` was read from in front of what it complains of.
template <typename Check>
auto At(const Place& place, const std::string& name, Check check) {
  try {
    return check();
  } catch (const InputError& error) {
    if (place.where.empty() || place.name != name) throw;
    throw InputError(fmt::format("{}: {}", place.where, error.what()));
  }
}

}  // namespace twin::scenario
