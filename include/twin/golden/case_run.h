#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "twin/golden/comparison.h"
#include "twin/golden/golden.h"
#include "twin/golden/page.h"
#include "twin/golden/pictures.h"
#include "twin/record/log_reader.h"
#include "twin/replay/recording.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"
#include "twin/scenario/video_case.h"

namespace twin::golden {

/// The pictures of a case.
[[nodiscard]] PicturePlan PlanOf(const scenario::VideoCase& wanted);

/// Requires that `log`, read by `reader`, is a run of the case. Ignores the scenario's camera.
/// @param scenario  the case's, with its lab and seed. @throws InputError naming the first
/// difference.
void RequireRunOf(const scenario::VideoCase& wanted, const scenario::Scenario& scenario,
                  const record::LogReader& reader, const std::filesystem::path& log);

/// The comparable data of a case's recorded run.
///
/// Threads: one thread.
class CaseRun {
 public:
  /// @param file  the case's file, for messages. @throws as replay::Recording.
  CaseRun(const scenario::VideoCase& wanted, std::filesystem::path file, std::filesystem::path log,
          const run::RunFiles& files);

  /// Takes the pictures. @param golden  its key frames are taken; null: those of the case.
  /// @param between  called between pictures; its exceptions propagate. @throws InputError naming
  /// the case's file if the model lacks a view's body or camera.
  void Take(const Golden* golden, const std::function<void()>& between);

  /// @pre Take(). Refers to this.
  [[nodiscard]] golden::Evidence Evidence() const;
  [[nodiscard]] const Pictures& pictures() const noexcept { return pictures_; }
  [[nodiscard]] JointCurves Joints() const { return ReadJointCurves(log_); }

 private:
  std::filesystem::path file_;
  PicturePlan plan_;
  std::filesystem::path log_;
  replay::Recording recording_;
  std::uint64_t states_ = 0;
  Pictures pictures_;
};

}  // namespace twin::golden
