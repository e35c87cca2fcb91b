#include "report/gnuplot.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/core/time.h"
#include "twin/rt/child_process.h"

namespace twin::report {
namespace {

/// Timeout for one picture, which usually takes 0.1 s.
constexpr Duration kTimeout = std::chrono::seconds(60);

std::string Message(int error) {
  return std::generic_category().message(error);
}

/// An open file.
class Descriptor {
 public:
  /// @param number  result of open(); this object takes ownership.
  Descriptor(int number, const std::string& name) : number_(number) {
    if (number_ < 0) {
      throw EnvironmentError(
          fmt::format("cannot create {}: {}; the folder must exist and be writable, or choose "
                      "another one",
                      name, Message(errno)));
    }
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] int number() const { return number_; }
  /// @returns whether all that was written is in the file: some file systems say so only here.
  [[nodiscard]] bool Close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

/// A file in memory. gnuplot reads its script from one and writes its messages to another, so that
/// no pipe can fill up and no file remains.
Descriptor MemoryFile(const char* name) {
  return {::memfd_create(name, MFD_CLOEXEC), name};
}

/// @param what  the failed action, for the error's text.
void WriteAll(const Descriptor& file, std::string_view text, std::string_view what) {
  while (!text.empty()) {
    const ssize_t written = ::write(file.number(), text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw EnvironmentError(fmt::format("{}: {}", what, Message(errno)));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// The first `most` bytes of `file`, or all if it is shorter.
std::string ReadAll(const Descriptor& file, std::size_t most) {
  std::string text(std::min(most, static_cast<std::size_t>(::lseek(file.number(), 0, SEEK_END))),
                   '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got =
        ::pread(file.number(), text.data() + size, text.size() - size, static_cast<off_t>(size));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    size += static_cast<std::size_t>(got);
  }
  text.resize(size);
  return text;
}

/// Runs gnuplot with the three standard files. @returns its wait status.
int RunGnuplot(const Descriptor& in, const Descriptor& out, const Descriptor& error) {
  try {
    // -d: without the user's settings. Without a file name it reads standard input byte by byte.
    rt::ChildProcess gnuplot("gnuplot", {"-d", "/dev/stdin"},
                             {.in = in.number(), .out = out.number(), .error = error.number()});
    if (const std::optional<int> status = gnuplot.Wait(kTimeout)) return *status;
  } catch (const std::system_error& failed) {
    throw EnvironmentError(fmt::format(
        "cannot run gnuplot, which draws the plots: {}; install it (Debian: apt-get install "
        "gnuplot-nox) or put its folder on PATH",
        failed.code().message()));
  }
  if (rt::GivesUp()) throw EnvironmentError("plots: interrupted; gnuplot was ended");
  throw EnvironmentError(
      fmt::format("gnuplot has not drawn a picture within {} s, and was ended; see what it waits "
                  "for, or say record: false",
                  ToSeconds(kTimeout)));
}

}  // namespace

std::string SvgOf(std::string_view script) {
  constexpr std::size_t kMessages = 4096;
  constexpr std::size_t kPicture = std::size_t{64} << 20;
  const Descriptor in = MemoryFile("gnuplot script");
  const Descriptor out = MemoryFile("gnuplot picture");
  const Descriptor error = MemoryFile("gnuplot messages");
  WriteAll(in, script, "cannot hand gnuplot its data");
  ::lseek(in.number(), 0, SEEK_SET);
  const int status = RunGnuplot(in, out, error);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw EnvironmentError(
        fmt::format("gnuplot {}: {}", rt::DescribeEnd(status), ReadAll(error, kMessages)));
  }
  std::string svg = ReadAll(out, kPicture);
  if (svg.find("</svg>") == std::string::npos) {
    throw EnvironmentError(fmt::format(
        "gnuplot drew only a part of the picture; is memory full? {}", ReadAll(error, kMessages)));
  }
  return svg;
}

void WriteSvg(std::string_view svg, const std::filesystem::path& path) {
  auto partial = path;
  partial += ".partial";
  try {
    const std::string failed = fmt::format("cannot write {}", partial.string());
    Descriptor out(::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644),
                   partial.string());
    WriteAll(out, svg, failed);
    if (!out.Close()) throw EnvironmentError(fmt::format("{}: {}", failed, Message(errno)));
    std::filesystem::rename(partial, path);
  } catch (const std::filesystem::filesystem_error& failure) {
    ::unlink(partial.c_str());
    throw EnvironmentError(fmt::format("cannot rename {} to its final name: {}", partial.string(),
                                       failure.code().message()));
  } catch (...) {
    ::unlink(partial.c_str());
    throw;
  }
}

}  // namespace twin::report
