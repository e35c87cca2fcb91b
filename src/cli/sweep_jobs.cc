#include "cli/sweep_jobs.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <list>
#include <memory>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "cli/command.h"
#include "twin/core/error.h"
#include "twin/rt/child_process.h"

namespace twin::cli {
namespace {

constexpr int kMostCrashes = 3;
constexpr int kLook = 10;  ///< ms; how long the last worker's end may go unnoticed

/// Both ends of a pipe, closed at the end of its life.
class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) {
      throw std::system_error(errno, std::generic_category(), "pipe");
    }
  }
  ~Pipe() {
    for (const int end : ends_) ::close(end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int reading() const noexcept { return ends_[0]; }
  [[nodiscard]] int writing() const noexcept { return ends_[1]; }

  /// @returns what was written, after waiting for it a little. @param most  ms.
  [[nodiscard]] std::string_view Read(int most) {
    pollfd wanted{.fd = reading(), .events = POLLIN, .revents = 0};
    if (::poll(&wanted, 1, most) <= 0) return {};
    const ssize_t count = ::read(reading(), bytes_.data(), bytes_.size());
    return {bytes_.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
  }

 private:
  std::array<int, 2> ends_{-1, -1};
  std::array<char, 4096> bytes_{};
};

/// A part of the shard and the process that carries it out.
class Worker {
 public:
  Worker(const SweepJobs& jobs, int number, int pipe) : pipe_(pipe) {
    arguments_ = {"-n", "10", jobs.executable.string()};
    arguments_.insert(arguments_.end(), jobs.arguments.begin(), jobs.arguments.end());
    const std::uint64_t parts = static_cast<std::uint64_t>(jobs.jobs);
    const std::uint64_t index =
        jobs.shard.index + static_cast<std::uint64_t>(number) * jobs.shard.count;
    arguments_.push_back(fmt::format("--shard={}/{}", index, jobs.shard.count * parts));
    Begin();
  }

  /// @returns whether it still works. Begins it anew when it crashed.
  [[nodiscard]] bool Works(Terminal& terminal) {
    if (!child_) return false;
    const std::optional<int> status = child_->Poll();
    if (!status) return true;
    child_.reset();
    if (*status == 0) return false;
    const std::string end = rt::DescribeEnd(*status);
    refused_ = WIFEXITED(*status) && WEXITSTATUS(*status) == kBadInput;
    if (!WIFSIGNALED(*status) || ++crashes_ > kMostCrashes) {
      failure_ = end;
      return false;
    }
    terminal.Warn(fmt::format("a worker {}; it is begun anew", end));
    Begin();
    return true;
  }

  [[nodiscard]] const std::string& failure() const noexcept { return failure_; }
  /// Whether it failed because a point is not acceptable.
  [[nodiscard]] bool refused() const noexcept { return refused_; }

 private:
  void Begin() {
    child_ = std::make_unique<rt::ChildProcess>(
        "nice", arguments_,
        rt::ChildProcess::Files{.in = -1, .out = -1, .error = STDERR_FILENO, .kept_open = pipe_});
  }

  const int pipe_;
  std::vector<std::string> arguments_;
  std::unique_ptr<rt::ChildProcess> child_;
  int crashes_ = 0;
  std::string failure_;
  bool refused_ = false;
};

}  // namespace

void RunJobs(const SweepJobs& jobs, Terminal& terminal) {
  Pipe pipe;
  std::list<Worker> workers;
  for (int i = 0; i < jobs.jobs; ++i) workers.emplace_back(jobs, i, pipe.writing());
  SweepProgress progress(jobs.runs, terminal);
  const auto tell = [&](std::string_view bytes) {
    const auto done = static_cast<std::uint64_t>(std::ranges::count(bytes, 'd'));
    progress.Add(bytes.size() - done, true);
    progress.Add(done, false);
  };
  for (bool works = true; works;) {
    works = false;
    for (Worker& worker : workers) works |= worker.Works(terminal);
    tell(pipe.Read(kLook));
    terminal.ThrowIfInterrupted();
  }
  for (std::string_view rest = pipe.Read(0); !rest.empty(); rest = pipe.Read(0)) tell(rest);
  for (const Worker& worker : workers) {
    if (worker.failure().empty()) continue;
    const std::string text =
        fmt::format("a worker {}, see above; what is done is kept: run the same command to go on",
                    worker.failure());
    if (worker.refused()) throw InputError(text);
    throw EnvironmentError(text);
  }
}

void SweepProgress::Add(std::uint64_t done, bool was_there) {
  if (done == 0) return;
  done_ += done;
  if (!was_there) carried_out_ += done;
  const double share = static_cast<double>(done_) / static_cast<double>(std::max(runs_, done_));
  std::string note = fmt::format("{} of {} runs", done_, runs_);
  if (carried_out_ > 0 && done_ < runs_) {
    const double each =
        ToSeconds(clock_.Now().time_since_epoch()) / static_cast<double>(carried_out_);
    note += fmt::format(", {:.0f} s left", each * static_cast<double>(runs_ - done_));
  }
  terminal_.Show("sweep", share, note);
}

}  // namespace twin::cli
