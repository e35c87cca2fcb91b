#include "twin/record/partial_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const char* what, const fs::path& path, int error) {
  throw EnvironmentError(
      fmt::format("cannot {} {}: {}; the folder must exist, be writable and have space left, or "
                  "choose another one",
                  what, path.string(), std::generic_category().message(error)));
}

/// @throws InputError if the file is not of this kind.
void RequireKind(const fs::path& path, const PartialFile::Kind& kind) {
  std::error_code error;
  if (kind.magic.empty() || !fs::is_regular_file(path, error) || fs::is_empty(path, error)) return;
  std::vector<char> begin(kind.magic.size());
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  const auto bytes = std::as_bytes(std::span(begin));
  if (file && std::ranges::equal(bytes, kind.magic)) return;
  throw InputError(
      fmt::format("{}: is there and is not {}, so it is not overwritten; choose another "
                  "name, or remove it",
                  path.string(), kind.name));
}

/// @returns the path. @throws as the constructor of PartialFile.
fs::path Replaceable(fs::path path, const PartialFile::Kind& kind) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    throw EnvironmentError(fmt::format(
        "cannot write {}: it is a directory; name a file in it, or another one", path.string()));
  }
  if (fs::exists(path, error) && !fs::is_regular_file(path, error)) {
    throw EnvironmentError(fmt::format(
        "cannot write {}: it is there and is no file; choose another name", path.string()));
  }
  RequireKind(path, kind);
  return path;
}

/// Puts a file or folder on the disk. @returns 0, or the errno.
int Sync(int file) {
  while (::fsync(file) != 0) {
    // Some network file systems sync no folders.
    if (errno == EINVAL || errno == ENOTSUP) return 0;
    if (errno != EINTR) return errno;
  }
  return 0;
}

/// Puts a folder's names on the disk.
void SyncFolder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;  // it may be written without being readable
  const int error = Sync(file);
  ::close(file);
  if (error != 0) Fail("keep the names in", folder, error);
}

}  // namespace

PartialFile::PartialFile(fs::path path, Leftover leftover, const Kind& kind)
    : path_(Replaceable(std::move(path), kind)), output_(path_, PartialOutput::Kind::kFile) {
  output_.Keep();  // until its kind is known
  RequireKind(output_.partial(), kind);
  if (leftover == Leftover::kRemove) output_.Remove();
  // A device cannot be truncated and need not be.
  if (::ftruncate(output_.lock(), 0) != 0 && errno != EINVAL) {
    Fail("empty", output_.partial(), errno);
  }
}

void PartialFile::Write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(output_.lock(), bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      Fail("write", output_.partial(), errno);
    }
    size_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void PartialFile::Commit() {
  // Some file systems report write errors only on close; the lock stays held.
  const int copy = ::dup(output_.lock());
  if (copy >= 0 && ::close(copy) != 0) Fail("close", output_.partial(), errno);
  output_.Publish();
}

void PartialFile::CommitSynced() {
  if (const int error = Sync(output_.lock()); error != 0) {
    Fail("write", output_.partial(), error);
  }
  Commit();
  SyncFolder(path_.has_parent_path() ? path_.parent_path() : ".");
}

}  // namespace twin::record
