#include "record/mcap_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::record::mcap {
namespace {

/// True if the user's path is wrong; other errors are the machine's.
bool NamesNoFile(int error) {
  return error == ENOENT || error == ENOTDIR || error == ELOOP || error == ENAMETOOLONG;
}

std::string Explain(const std::filesystem::path& path, const std::string& cause) {
  return fmt::format("cannot read {}: {}; name a file that is there and that you may read",
                     path.string(), cause);
}

[[noreturn]] void FailToRead(const std::filesystem::path& path, const std::string& cause) {
  throw EnvironmentError(Explain(path, cause));
}

std::string LastError() {
  return std::generic_category().message(errno);
}

class FileSource final : public Source {
 public:
  explicit FileSource(const std::filesystem::path& path) : path_(path) {
    // O_NONBLOCK: opening a named pipe does not wait for its writer.
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0) {
      if (NamesNoFile(errno)) throw InputError(Explain(path_, LastError()));
      FailToRead(path_, LastError());
    }
    struct stat status {};
    const bool known = ::fstat(descriptor_, &status) == 0;
    if (known && S_ISREG(status.st_mode)) {
      size_ = static_cast<std::uint64_t>(status.st_size);
      return;
    }
    const std::string cause = known ? "it is not a file" : LastError();
    ::close(descriptor_);
    if (known) throw InputError(Explain(path_, cause));
    FailToRead(path_, cause);
  }
  ~FileSource() override { ::close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }

  std::size_t ReadAt(std::uint64_t offset, std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done,
                                  static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) FailToRead(path_, LastError());
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

class MemorySource final : public Source {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }

  std::size_t ReadAt(std::uint64_t offset, std::span<std::byte> out) override {
    if (offset >= bytes_.size()) return 0;
    const auto part = bytes_.subspan(offset);
    const std::size_t count = std::min(part.size(), out.size());
    std::copy_n(part.begin(), count, out.begin());
    return count;
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace

std::unique_ptr<Source> OpenFile(const std::filesystem::path& path) {
  return std::make_unique<FileSource>(path);
}

std::unique_ptr<Source> OpenMemory(std::span<const std::byte> bytes) {
  return std::make_unique<MemorySource>(bytes);
}

}  // namespace twin::record::mcap
