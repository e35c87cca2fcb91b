#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/interrupt.h"
#include "cli/video_command.h"
#include "twin/golden/joint_curves.h"
#include "twin/golden/page.h"
#include "twin/golden/pictures.h"
#include "twin/replay/recording.h"
#include "twin/scenario/video_case.h"

namespace twin::cli {

/// A case that was run, or whose recorded run is taken: all that can be compared of it.
class VideoCaseRun {
 public:
  /// Runs the case, unless the flags name a log. A run that fails is taken as it came out: its
  /// pictures tell more.
  /// @throws InputError for a scenario, lab or log that is not acceptable, a log of another run
  /// than the case's, and, to approve, one of a run that was killed; EnvironmentError without the
  /// robot's meshes; Interrupted.
  VideoCaseRun(const scenario::VideoCase& wanted, const VideoFlags& flags, const Host& host,
               const run::Catalogue& catalogue);

  /// Takes the pictures. @param golden  whose key frames are taken; null: by the case.
  /// @throws Interrupted; InputError naming the case's file when a view's body or camera is not in
  /// the model.
  void Take(const golden::Golden* golden, const InterruptGuard& interrupt);

  /// @pre Take(). Refers to this.
  [[nodiscard]] golden::Evidence Evidence() const;
  [[nodiscard]] const golden::Pictures& pictures() const noexcept { return pictures_; }
  [[nodiscard]] golden::JointCurves Joints() const { return golden::ReadJointCurves(log_); }

 private:
  void Run(const scenario::VideoCase& wanted, const VideoFlags& flags, const Host& host,
           const run::Catalogue& catalogue);

  std::filesystem::path file_;  ///< of the case, for messages
  golden::PicturePlan plan_;
  std::filesystem::path log_;
  std::optional<replay::Recording> recording_;
  std::uint64_t states_ = 0;
  golden::Pictures pictures_;
};

}  // namespace twin::cli
