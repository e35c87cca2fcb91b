#include "cli/result_folder.h"

#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailToWrite(const fs::path& path, const std::string& why) {
  throw EnvironmentError(fmt::format(
      "{}: cannot be written ({}); choose a folder of your own with --out, or make room",
      path.string(), why));
}

}  // namespace

ResultFolder::ResultFolder(fs::path folder) : folder_(std::move(folder)) {}

void ResultFolder::Prepare() const {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) FailToWrite(folder_, error.message());
  if (!fs::is_directory(folder_, error)) FailToWrite(folder_, "not a folder");
  const fs::path probe = folder_ / "probe.partial";
  if (!std::ofstream(probe)) FailToWrite(folder_, "permission denied");
  fs::remove(probe, error);
}

void ResultFolder::Clear() const {
  RemovePartial();
  std::vector<fs::path> old{log(), scenario(), video(), contact_sheet(), summary(), timing()};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(plots(), error)) {
    if (entry.path().extension() == ".svg") old.push_back(entry.path());
  }
  for (const fs::path& file : old) {
    fs::remove(file, error);
    if (error) FailToWrite(file, error.message());
  }
}

void ResultFolder::RemovePartial() const noexcept {
  std::error_code error;
  for (const fs::path& folder : {folder_, plots()}) {
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".partial") fs::remove(entry.path(), error);
    }
  }
}

void WriteWholeFile(const fs::path& file, std::string_view text) {
  const fs::path partial = file.string() + ".partial";
  std::ofstream out(partial, std::ios::binary);
  out << text << std::flush;
  if (!out) FailToWrite(partial, "disk full or permission denied");
  out.close();
  std::error_code error;
  fs::rename(partial, file, error);
  if (error) FailToWrite(file, error.message());
}

}  // namespace twin::cli
