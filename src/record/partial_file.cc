#include "twin/record/partial_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record {
namespace {

[[noreturn]] void Fail(const char* what, const std::filesystem::path& path, int error) {
  throw EnvironmentError(
      fmt::format("cannot {} {}: {}; the folder must exist, be writable and have space left, or "
                  "choose another one",
                  what, path.string(), std::generic_category().message(error)));
}

}  // namespace

PartialFile::PartialFile(std::filesystem::path path, Leftover leftover)
    : path_(std::move(path)), partial_(path_), leftover_(leftover) {
  partial_ += ".partial";
  std::error_code unknown;
  if (std::filesystem::is_directory(path_, unknown)) {
    throw EnvironmentError(fmt::format(
        "cannot write {}: it is a directory; name a file in it, or another one", path_.string()));
  }
  descriptor_ = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) Fail("create", partial_, errno);
}

PartialFile::~PartialFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (leftover_ == Leftover::kRemove) ::unlink(partial_.c_str());
}

void PartialFile::Write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      Fail("write", partial_, errno);
    }
    size_ += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void PartialFile::Commit() {
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) Fail("close", partial_, errno);
  if (::rename(partial_.c_str(), path_.c_str()) != 0)
    Fail("rename to its final name", partial_, errno);
}

}  // namespace twin::record
