#include "twin/plant/engine.h"

#include <mujoco/mujoco.h>

namespace twin::plant {
namespace {

// MuJoCo's handlers carry no context; the collector is thread-local.
thread_local EngineWarnings* innermost = nullptr;

[[noreturn]] void ThrowFault(const char* text) {
  throw EngineFault(text);
}

}  // namespace

void RecordEngineWarning(const char* text) {
  if (innermost != nullptr) innermost->texts_.emplace_back(text);
}

void InstallEngineHandlers() noexcept {
  // Once: models are made on several threads, and the engine's handlers are plain globals.
  [[maybe_unused]] static const bool installed = [] {
    mju_user_error = ThrowFault;
    mju_user_warning = RecordEngineWarning;
    return true;
  }();
}

EngineWarnings::EngineWarnings() noexcept : outer_(innermost) {
  innermost = this;
}

EngineWarnings::~EngineWarnings() {
  innermost = outer_;
}

}  // namespace twin::plant
