#pragma once

#include <filesystem>
#include <string_view>

namespace twin::cli {

/// The folder a run writes to, with the names of what it writes.
///
/// A folder never shows the results of two runs: Clear() takes away those of an earlier one, by
/// name; other files are left alone.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path folder);

  /// Makes the folder and tries that it can be written to. @throws EnvironmentError naming it.
  void Prepare() const;
  /// Removes what an earlier run left. @throws EnvironmentError naming what cannot be removed.
  void Clear() const;
  /// Removes all that is `.partial`.
  void RemovePartial() const noexcept;

  [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
  [[nodiscard]] std::filesystem::path log() const { return folder_ / "run.mcap"; }
  [[nodiscard]] std::filesystem::path scenario() const { return folder_ / "scenario.yaml"; }
  [[nodiscard]] std::filesystem::path plots() const { return folder_ / "plots"; }
  [[nodiscard]] std::filesystem::path video() const { return folder_ / "video.mp4"; }
  [[nodiscard]] std::filesystem::path contact_sheet() const {
    return folder_ / "contact_sheet.png";
  }
  [[nodiscard]] std::filesystem::path summary() const { return folder_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path timing() const { return folder_ / "timing.json"; }

 private:
  std::filesystem::path folder_;
};

/// Writes a file that is `.partial` until it is whole. @throws EnvironmentError naming the file.
void WriteWholeFile(const std::filesystem::path& file, std::string_view text);

}  // namespace twin::cli
