#include "plant/model_cache.h"

#include <unistd.h>

#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "plant/file_bytes.h"
#include "twin/core/error.h"

namespace twin::plant {
namespace {

std::string HeaderOf(const std::string& payload) {
  ContentHash hash;
  hash.Add(payload);
  return fmt::format("panda-twin compiled model 1, {} bytes, {}\n", payload.size(), hash.Hex());
}

[[noreturn]] void FailCorrupt(const std::filesystem::path& file, const char* what) {
  throw EnvironmentError(
      fmt::format("{}: the cached model is corrupt: {}. Delete the file, or pass --rebuild-cache",
                  file.string(), what));
}

}  // namespace

ModelCache::ModelCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

std::filesystem::path ModelCache::FileOf(const std::string& key) const {
  return folder_ / (key + ".mjb");
}

std::optional<std::string> ModelCache::Load(const std::string& key) const {
  const std::filesystem::path file = FileOf(key);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  std::string bytes;
  try {
    bytes = ReadFileBytes(file, "the cached model");
  } catch (const InputError& failure) {
    throw EnvironmentError(
        fmt::format("{}. Delete the file, or pass --rebuild-cache", failure.what()));
  }
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos) FailCorrupt(file, "it has no header");
  const std::string header = bytes.substr(0, end + 1);
  bytes.erase(0, end + 1);
  if (header != HeaderOf(bytes)) FailCorrupt(file, "length or fingerprint differ from its header");
  return bytes;
}

void ModelCache::Store(const std::string& key, const std::string& payload) const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  const std::filesystem::path file = FileOf(key);
  const std::filesystem::path partial =
      folder_ / fmt::format("{}.mjb.{}.partial", key, static_cast<long>(gettid()));
  std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
  stream << HeaderOf(payload) << payload;
  stream.close();
  if (stream) std::filesystem::rename(partial, file, error);
  if (stream && !error) return;
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  throw EnvironmentError(
      fmt::format("{}: cannot write to the folder of compiled models. Make it writable, or choose "
                  "another cache folder",
                  folder_.string()));
}

}  // namespace twin::plant
