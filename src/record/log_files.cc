#include "record/log_files.h"

#include <array>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "record/mcap_format.h"
#include "twin/core/error.h"
#include "twin/record/log_split.h"
#include "twin/record/partial_output.h"

namespace twin::record {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPartial = ".partial";

fs::path FolderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

bool IsLog(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::array<char, mcap::kMagic.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), begin.size()) &&
         std::string_view(begin.data(), begin.size()) == mcap::kMagic;
}

}  // namespace

LogFiles::LogFiles(fs::path log) : log_(std::move(log)) {}

std::multimap<std::size_t, fs::path> LogFiles::Find() const {
  std::multimap<std::size_t, fs::path> files;
  const std::string head = log_.stem().string() + "_";
  std::error_code error;  // a folder that cannot be read shows when a file is to be created in it
  for (fs::directory_iterator at(FolderOf(log_), error), end; !error && at != end;
       at.increment(error)) {
    std::string name = at->path().filename().string();
    if (name.ends_with(kPartial)) name.resize(name.size() - kPartial.size());
    if (!name.starts_with(head)) continue;
    std::size_t number = 0;
    std::from_chars(name.data() + head.size(), name.data() + name.size(), number);
    if (number > 0 && name == LogPart(log_, number).filename()) files.emplace(number, at->path());
  }
  return files;
}

std::size_t LogFiles::Next() const {
  const auto files = Find();
  if (files.empty()) return 1;
  const auto& [number, newest] = *files.rbegin();
  if (newest.extension() == kPartial) {
    PartialOutput(LogPart(log_, number), PartialOutput::Kind::kFile).Keep();  // refused if in use
  }
  return number + 1;
}

void LogFiles::Prune(std::size_t keep, std::size_t last) const {
  std::vector<fs::path> ended;
  for (const auto& [number, path] : Find()) {
    if (number <= last && IsLog(path)) ended.push_back(path);
  }
  for (std::size_t i = 0; i + keep < ended.size(); ++i) {
    std::error_code error;
    fs::remove(ended[i], error);
    if (error) {
      throw EnvironmentError(
          fmt::format("cannot remove the old log {}: {}; make its folder "
                      "writable, or keep all logs",
                      ended[i].string(), error.message()));
    }
  }
}

}  // namespace twin::record
