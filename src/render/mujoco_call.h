#pragma once

#include <string>
#include <utility>

#include "twin/core/error.h"
#include "twin/plant/engine.h"

namespace twin::render {

/// Runs `call`; a MuJoCo error becomes an EnvironmentError that begins with `what`.
template <typename Call>
decltype(auto) MujocoCall(const char* what, Call&& call) {
  plant::InstallEngineHandlers();
  try {
    return std::forward<Call>(call)();
  } catch (const plant::EngineFault& fault) {
    throw EnvironmentError(std::string(what) + ": MuJoCo says \"" + fault.what() + "\"");
  }
}

}  // namespace twin::render
