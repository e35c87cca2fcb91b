#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace twin::run {

/// The folder a run writes to, with the names of what it writes.
///
/// A folder never shows the results of two runs: Clear() takes away those of an earlier one, by
/// name; other files are left alone. From Prepare() on the folder is locked against other runs, as
/// long as this lives.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path folder);
  /// Unlocks the folder.
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  /// Makes the folder, locks it, and tries that it and its plots can be written to. Once.
  /// @throws EnvironmentError naming it; also when another run writes into it.
  void Prepare();
  /// Removes what an earlier run left. @throws EnvironmentError naming what cannot be removed.
  void Clear() const;
  /// Removes those of a run's files that are not whole. @param but_log  leaves the log's.
  void RemovePartial(bool but_log = false) const;

  /// Whether a run writes this file, or its part until it is whole.
  [[nodiscard]] bool Holds(const std::filesystem::path& file) const;

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
  [[nodiscard]] std::filesystem::path snapshots() const { return folder_ / "moments"; }
  [[nodiscard]] std::filesystem::path summary() const { return folder_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path timing() const { return folder_ / "timing.json"; }
  /// Not a run writes it, but who asks for it; it goes with the run.
  [[nodiscard]] std::filesystem::path explanation() const { return folder_ / "explain.html"; }

 private:
  void Lock();
  /// All that a run may write.
  [[nodiscard]] std::vector<std::filesystem::path> Files() const;

  std::filesystem::path folder_;
  int lock_ = -1;  ///< descriptor of the folder
};

/// The log that the user means: a file, or a run's folder, whose log may not be whole.
/// @throws InputError when the folder holds none.
[[nodiscard]] std::filesystem::path FindLog(const std::filesystem::path& named);

/// Makes a file of its own in `folder`, and removes it. @throws EnvironmentError when it cannot.
void TryToWrite(const std::filesystem::path& folder);

/// Makes a folder, and those it is in, unless it is there. @throws EnvironmentError naming it.
void MakeFolder(const std::filesystem::path& folder);

/// What a file is called until it is whole.
[[nodiscard]] std::filesystem::path PartialOf(std::filesystem::path file);

/// Writes a file that is `.partial` until it is whole. @throws EnvironmentError naming the file.
void WriteWholeFile(const std::filesystem::path& file, std::string_view text);

}  // namespace twin::run
