#include "twin/run/result_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/report/plots.h"

namespace twin::run {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailToWrite(const fs::path& path, const std::string& why) {
  throw EnvironmentError(fmt::format(
      "{}: cannot be written ({}); choose a folder of your own with --out, or make room",
      path.string(), why));
}

/// Without links where they can be read: a folder without permission is reported on writing.
fs::path Resolved(const fs::path& file) {
  std::error_code error;
  fs::path resolved = fs::weakly_canonical(file, error);
  return error ? fs::absolute(file).lexically_normal() : resolved;
}

std::string LastError() {
  return std::generic_category().message(errno);
}

}  // namespace

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be made ({}); choose a folder of your own with --out, or make room",
                    folder.string(), error.message()));
  }
}

ScratchFolder::ScratchFolder(fs::path path) : path_(std::move(path)) {
  MakeFolder(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void TryToWrite(const fs::path& folder) {
  std::string probe = folder / ".panda-twin.XXXXXX";
  const int descriptor = ::mkostemp(probe.data(), O_CLOEXEC);
  if (descriptor < 0) FailToWrite(folder, LastError());
  ::close(descriptor);
  ::unlink(probe.c_str());
}

fs::path PartialOf(fs::path file) {
  return file += ".partial";
}

ResultFolder::ResultFolder(fs::path folder) : folder_(std::move(folder)) {}

ResultFolder::~ResultFolder() {
  if (lock_ >= 0) ::close(lock_);
}

void ResultFolder::Prepare() {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) FailToWrite(folder_, error.message());
  if (!fs::is_directory(folder_, error)) FailToWrite(folder_, "not a folder");
  Lock();
  TryToWrite(folder_);
  const fs::file_status plots_status = fs::symlink_status(plots(), error);
  if (plots_status.type() == fs::file_type::not_found) return;
  if (!fs::is_directory(plots(), error)) FailToWrite(plots(), "not a folder");
  TryToWrite(plots());
}

void ResultFolder::Lock() {
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) FailToWrite(folder_, LastError());
  // Where the file system knows no locks, a run goes without.
  if (::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  throw EnvironmentError(fmt::format(
      "another run writes into {}; wait for it or choose another --out", folder_.string()));
}

std::vector<fs::path> ResultFolder::Files() const {
  std::vector<fs::path> files{log(),     scenario(),   video(),       contact_sheet(),
                              summary(), timing(),     explanation(), plan_initial(),
                              plan(),    plan_final(), report(),      seeds()};
  for (const char* plot : report::kPlotFiles) files.push_back(plots() / plot);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(snapshots(), error)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  for (const fs::path& motion : MotionFolders()) {
    const std::vector<fs::path> of_motion = ResultFolder(motion).Files();
    files.insert(files.end(), of_motion.begin(), of_motion.end());
  }
  return files;
}

std::vector<fs::path> ResultFolder::MotionFolders() const {
  std::vector<fs::path> folders;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(motions(), error)) {
    const std::string name = entry.path().filename();
    const bool is_number = std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
    if (is_number && entry.is_directory(error) && !entry.is_symlink(error)) {
      folders.push_back(entry.path());
    }
  }
  return folders;
}

bool ResultFolder::Holds(const fs::path& file) const {
  const fs::path there = Resolved(file);
  return std::ranges::any_of(Files(), [&](const fs::path& own) {
    const fs::path ours = Resolved(own);
    return there == ours || there == PartialOf(ours);
  });
}

void ResultFolder::RequireOther(const fs::path& input) const {
  if (!Holds(input)) return;
  throw InputError(fmt::format(
      "{} is a result of an earlier run, which this run would replace; choose another --out",
      input.string()));
}

void ResultFolder::Clear() const {
  RemovePartial();
  for (const fs::path& file : Files()) {
    std::error_code error;
    fs::remove(file, error);
    if (error) FailToWrite(file, error.message());
  }
  for (const fs::path& motion : MotionFolders()) {
    std::error_code holds_other_files;
    fs::remove(ResultFolder(motion).plots(), holds_other_files);
    fs::remove(motion, holds_other_files);
  }
}

void ResultFolder::RemovePartial(bool but_log) const {
  for (const fs::path& file : Files()) {
    if (but_log && file == log()) continue;
    std::error_code ignored;
    fs::remove(PartialOf(file), ignored);
  }
}

fs::path FindLog(const fs::path& named) {
  std::error_code error;
  if (!fs::is_directory(named, error)) return named;
  const ResultFolder results(named);
  if (fs::exists(results.log(), error)) return results.log();
  fs::path partial = PartialOf(results.log());
  if (fs::exists(partial, error)) return partial;
  const std::string name = results.log().filename().string();
  for (const fs::directory_entry& entry : fs::directory_iterator(named, error)) {
    if (!fs::exists(entry.path() / name, error)) continue;
    throw InputError(fmt::format("{} holds no {}, but its folders do; name one, such as {}",
                                 named.string(), name, entry.path().string()));
  }
  throw InputError(fmt::format(
      "{} holds no {}; name a run's log, or the folder of a run that kept one (record: true)",
      named.string(), name));
}

void WriteWholeFile(const fs::path& file, std::string_view text) {
  const fs::path partial = PartialOf(file);
  std::ofstream out(partial, std::ios::binary);
  out << text;
  out.close();  // some file systems report write errors only here
  if (!out) FailToWrite(partial, "disk full or permission denied");
  std::error_code error;
  fs::rename(partial, file, error);
  if (error) FailToWrite(file, error.message());
}

}  // namespace twin::run
