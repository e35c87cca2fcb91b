#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace twin::plant {

/// A MuJoCo error that would have ended the process. Areas that call MuJoCo catch and translate it.
class EngineFault : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Makes MuJoCo's errors throw EngineFault (its own handler waits on stdin, exits, and writes
/// MUJOCO_LOG.TXT) and routes its warnings to EngineWarnings. Call it before any MuJoCo call that
/// can fail; repeated calls are harmless. Any thread.
void InstallEngineHandlers() noexcept;

/// Collects MuJoCo's warnings on this thread during its lifetime; the innermost instance collects.
/// Without one, warnings are dropped here; those of a step are counted in the plant's data. Not for
/// real-time code.
class EngineWarnings {
 public:
  EngineWarnings() noexcept;
  ~EngineWarnings();
  EngineWarnings(const EngineWarnings&) = delete;
  EngineWarnings& operator=(const EngineWarnings&) = delete;

  [[nodiscard]] const std::vector<std::string>& texts() const noexcept { return texts_; }

 private:
  friend void RecordEngineWarning(const char* text);
  EngineWarnings* outer_;
  std::vector<std::string> texts_;
};

}  // namespace twin::plant
