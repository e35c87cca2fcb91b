#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace twin::plant {

/// What MuJoCo would have ended the process for. Areas that call MuJoCo catch it at their border
/// and translate it.
class EngineFault : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Makes MuJoCo's errors throw EngineFault (its own handler waits on stdin, exits, and writes
/// MUJOCO_LOG.TXT) and its warnings go to EngineWarnings. To be called before any other call of
/// MuJoCo that can fail; repeating it does no harm. Any thread.
void InstallEngineHandlers() noexcept;

/// Collects what MuJoCo warns of on this thread while it lives; they nest, the innermost collects.
/// Outside of any, warnings are dropped here: those of a step are counted in the plant's data. Not
/// for real-time code.
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
