#include "twin/record/partial_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "twin/core/error.h"

namespace twin::record {
namespace {

constexpr mode_t kAnyFile = 0666;  // before the umask, as the next
constexpr mode_t kAnyFolder = 0777;

std::string MessageOf(int error) {
  return std::generic_category().message(error);
}

}  // namespace

PartialOutput::PartialOutput(std::filesystem::path path, Kind kind)
    : path_(std::move(path)), partial_(path_) {
  partial_ += ".partial";
  // Between opening and locking, another writer may have renamed or removed it.
  do {
    const int error = Open(kind);
    if (error != 0) {
      throw EnvironmentError(
          fmt::format("cannot create {}: {}; the folder must exist, be writable and have space "
                      "left, or choose another one",
                      partial_.string(), MessageOf(error)));
    }
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      Close();
      throw EnvironmentError(
          fmt::format("another run writes {}; wait for it or choose another name", path_.string()));
    }
  } while (!IsOurs());
}

PartialOutput::~PartialOutput() {
  std::error_code ignored;
  if (!keeps_ && IsOurs()) std::filesystem::remove(partial_, ignored);
  Close();
}

void PartialOutput::Close() noexcept {
  if (lock_ >= 0) ::close(lock_);
  lock_ = -1;
}

void PartialOutput::Publish() {
  std::error_code error;
  if (!IsOurs()) error = std::make_error_code(std::errc::no_such_file_or_directory);
  if (!error) std::filesystem::rename(partial_, path_, error);
  if (error) {
    throw EnvironmentError(fmt::format("{}: cannot be given the name {} ({})", partial_.string(),
                                       path_.string(), error.message()));
  }
}

bool PartialOutput::IsOurs() const noexcept {
  struct stat mine {};
  struct stat there {};
  return ::fstat(lock_, &mine) == 0 && ::stat(partial_.c_str(), &there) == 0 &&
         mine.st_dev == there.st_dev && mine.st_ino == there.st_ino;
}

int PartialOutput::Open(Kind kind) {
  const bool folder = kind == Kind::kFolder;
  if (folder && ::mkdir(partial_.c_str(), kAnyFolder) != 0 && errno != EEXIST) return errno;
  const int flags = folder ? O_RDONLY | O_DIRECTORY | O_NOFOLLOW : O_RDWR | O_CREAT;
  Close();
  lock_ = ::open(partial_.c_str(), flags | O_CLOEXEC, kAnyFile);
  if (lock_ >= 0) return 0;
  // Another writer has just published this folder: retry.
  return folder && errno == ENOENT ? 0 : errno;
}

}  // namespace twin::record
