#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace twin::run {

/// The folder of a run's or a served session's results, and the names of its files.
///
/// A folder never holds the results of two runs: Clear() removes those of an earlier one, by name,
/// and leaves other files. From Prepare() on, for the lifetime of the object, the folder is locked
/// against other runs.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path folder);
  /// Unlocks the folder.
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// Creates and locks the folder, and tries to write into it and its plots. To be called once.
  /// @throws EnvironmentError naming it; also when another run writes into it.
  void Prepare();
  /// Removes what an earlier run left. @throws EnvironmentError naming what cannot be removed.
  void Clear() const;
  /// Removes a run's incomplete files. @param but_log  leaves that of the log.
  void RemovePartial(bool but_log = false) const;

  /// Whether a run writes this file, or its incomplete form.
  [[nodiscard]] bool Holds(const std::filesystem::path& file) const;
  /// @throws InputError if Holds(input): the run would replace its own input.
  void RequireOther(const std::filesystem::path& input) const;

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
  [[nodiscard]] std::filesystem::path log() const { return folder_ / "run.mcap"; }
  [[nodiscard]] std::filesystem::path scenario() const { return folder_ / "scenario.yaml"; }
  [[nodiscard]] std::filesystem::path plots() const { return folder_ / "plots"; }
  [[nodiscard]] std::filesystem::path video() const { return folder_ / "video.mp4"; }
  [[nodiscard]] std::filesystem::path contact_sheet() const {
    return folder_ / "contact_sheet.png";
  }
  /// Of a planned motion.
  [[nodiscard]] std::filesystem::path plan_initial() const { return folder_ / "plan_initial.png"; }
  [[nodiscard]] std::filesystem::path plan() const { return folder_ / "plan.png"; }
  [[nodiscard]] std::filesystem::path plan_final() const { return folder_ / "plan_final.png"; }
  /// Of an application: its page, and its pictures, two of each snapshot.
  [[nodiscard]] std::filesystem::path report() const { return folder_ / "report.html"; }
  /// Of many seeds: a line each.
  [[nodiscard]] std::filesystem::path seeds() const { return folder_ / "seeds.csv"; }
  [[nodiscard]] std::filesystem::path snapshots() const { return folder_ / "snapshots"; }
  [[nodiscard]] std::filesystem::path summary() const { return folder_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path timing() const { return folder_ / "timing.json"; }
  /// Of a served session: the folder of a motion, which is as a run's.
  /// @param number  of the motion, from 1 on.
  [[nodiscard]] std::filesystem::path motion(std::size_t number) const {
    return motions() / std::to_string(number);
  }
  /// Written by the command explain; Clear() removes it too.
  [[nodiscard]] std::filesystem::path explanation() const { return folder_ / "explain.html"; }

 private:
  void Lock();
  [[nodiscard]] std::filesystem::path motions() const { return folder_ / "motions"; }
  /// The folders of a served session's motions.
  [[nodiscard]] std::vector<std::filesystem::path> MotionFolders() const;
  /// All that a run may write.
  [[nodiscard]] std::vector<std::filesystem::path> Files() const;

  std::filesystem::path folder_;
  int lock_ = -1;  ///< descriptor of the folder
};

/// The log that a path names: a file, or a run's folder, whose log may be incomplete.
/// @throws InputError when the folder holds none.
[[nodiscard]] std::filesystem::path FindLog(const std::filesystem::path& named);

/// Creates a temporary file in `folder`, and removes it. @throws EnvironmentError when it cannot.
void TryToWrite(const std::filesystem::path& folder);

/// Creates a folder and its parents unless they exist. @throws EnvironmentError naming it.
void MakeFolder(const std::filesystem::path& folder);

/// A folder that is removed with this, unless it has got another name.
class ScratchFolder {
 public:
  /// @throws as MakeFolder.
  explicit ScratchFolder(std::filesystem::path path);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

/// The name of a file until it is complete.
[[nodiscard]] std::filesystem::path PartialOf(std::filesystem::path file);

/// Writes a file, which is `.partial` until it is complete. @throws EnvironmentError naming the
/// file.
void WriteWholeFile(const std::filesystem::path& file, std::string_view text);

}  // namespace twin::run
