#include "twin/plant/model_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "plant/file_bytes.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

namespace fs = std::filesystem;

std::string HeaderOf(const std::string& payload) {
  ContentHash hash;
  hash.Add(payload);
  return fmt::format("panda-twin compiled model 1, {} bytes, {}\n", payload.size(), hash.Hex());
}

/// @returns the payload of an entry's file if complete.
std::optional<std::string> PayloadOf(const fs::path& file) {
  std::string bytes;
  try {
    bytes = ReadFileBytes(file, "the compiled model");
  } catch (const InputError&) {
    return std::nullopt;
  }
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos) return std::nullopt;
  const std::string header = bytes.substr(0, end + 1);
  bytes.erase(0, header.size());
  if (header != HeaderOf(bytes)) return std::nullopt;
  return bytes;
}

bool IsModel(const fs::path& file) {
  return file.extension() == ".mjb";
}

/// Whether the file is being written, or was when its process was killed.
bool IsUnfinished(const fs::path& file) {
  return file.extension() == ".partial" &&
         file.filename().string().find(".mjb.") != std::string::npos;
}

bool CanBeWritten(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  std::string probe = folder / ".panda-twin.XXXXXX";
  const int descriptor = ::mkostemp(probe.data(), O_CLOEXEC);
  if (descriptor < 0) return false;
  ::close(descriptor);
  return ::unlink(probe.c_str()) == 0;
}

}  // namespace

ModelCache::ModelCache(fs::path folder) : folder_(std::move(folder)) {}

fs::path ModelCache::FileOf(const std::string& key) const {
  return folder_ / (key + ".mjb");
}

std::optional<std::string> ModelCache::Load(const std::string& key) const {
  const fs::path file = FileOf(key);
  std::optional<std::string> payload = PayloadOf(file);
  // Marks it as used now. If that fails, it keeps its age.
  if (payload) static_cast<void>(::utimensat(AT_FDCWD, file.c_str(), nullptr, 0));
  return payload;
}

void ModelCache::Store(const std::string& key, const std::string& payload) const {
  std::error_code error;
  fs::create_directories(folder_, error);
  const fs::path partial =
      folder_ / fmt::format("{}.mjb.{}.partial", key, static_cast<long>(gettid()));
  std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
  stream << HeaderOf(payload) << payload;
  stream.close();
  if (stream) fs::rename(partial, FileOf(key), error);
  if (stream && !error) return;
  fs::remove(partial, error);
}

bool RepairModelCache(const fs::path& folder, const std::function<void(std::string_view)>& note) {
  if (!CanBeWritten(folder)) {
    note(
        fmt::format("{}: compiled models cannot be kept there, so that each run compiles its own; "
                    "make the folder writable, or name another by XDG_CACHE_HOME",
                    folder.string()));
    return false;
  }
  std::vector<std::pair<fs::file_time_type, fs::path>> kept;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path& file = entry.path();
    if (!IsModel(file) && !IsUnfinished(file)) continue;
    if (IsModel(file) && !PayloadOf(file) && fs::remove(file, error)) {
      note(fmt::format("{}: the compiled model that was kept is damaged; it is compiled anew",
                       file.string()));
      continue;
    }
    kept.emplace_back(entry.last_write_time(error), file);
  }
  if (kept.size() <= kMostCachedModels) return true;
  std::ranges::sort(kept, std::ranges::greater());
  for (std::size_t i = kMostCachedModels; i < kept.size(); ++i) fs::remove(kept[i].second, error);
  return true;
}

}  // namespace twin::plant
