#include "cli/log.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <mutex>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/async_logger.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/base_sink.h>
#include <nlohmann/json.hpp>

#include "cli/interrupt.h"
#include "twin/core/error.h"

namespace twin::cli {
namespace {

constexpr std::array kLevels{"trace", "debug", "note", "warning", "error", "error", "off"};

std::string JsonLine(const spdlog::details::log_msg& message, std::string_view text) {
  using Json = nlohmann::ordered_json;
  const auto time = std::chrono::floor<std::chrono::seconds>(message.time);
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(message.time - time);
  const Json json{{"time", fmt::format("{:%FT%T}.{:03d}Z", fmt::gmtime(time), ms.count())},
                  {"level", kLevels[message.level]},
                  {"message", text}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

/// In one line; of a text that is endless, its begin and its end, which has the cure.
std::string OneLine(std::string_view text) {
  constexpr std::size_t kMost = 2000;
  std::string line(text);
  if (line.size() > kMost) line.replace(kMost / 2, line.size() - kMost, " ... ");
  std::ranges::replace(line, '\n', ' ');
  std::ranges::replace(line, '\r', ' ');
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

/// Waits until whoever reads `descriptor` takes something; a pipe then takes PIPE_BUF bytes at
/// once. @returns false when `gives_up`, which is asked 20 times a second, says so before that.
bool AwaitReader(int descriptor, const auto& gives_up) noexcept {
  constexpr int kPeriod_ms = 50;
  while (true) {
    pollfd ready{.fd = descriptor, .events = POLLOUT, .revents = 0};
    const int count = ::poll(&ready, 1, kPeriod_ms);
    if (count > 0 || (count < 0 && errno != EINTR)) return true;  // writing tells what is wrong
    if (gives_up()) return false;
  }
}

class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit StderrSink(const LogFlags& flags) : flags_(flags) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (message.level < spdlog::level::info && !flags_.verbose) return;
    const std::string text = OneLine({message.payload.data(), message.payload.size()});
    std::fflush(stdout);
    Say(stderr, flags_.is_json()
                    ? JsonLine(message, text)
                    : fmt::format("panda-twin: {}: {}\n", kLevels[message.level], text));
  }
  void flush_() override { std::fflush(stderr); }

  const LogFlags& flags_;
};

}  // namespace

Log MakeLog(const LogFlags& flags) {
  Log log = std::make_shared<spdlog::logger>("panda-twin", std::make_shared<StderrSink>(flags));
  log->set_level(spdlog::level::debug);
  return log;
}

class EventLog::Sink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit Sink(const LogFlags& flags) : flags_(flags) {}

  std::atomic<std::size_t> dropped = 0;  ///< lines so far; relaxed, as it only counts
  std::atomic<bool> ends = false;        ///< set once; relaxed, as it publishes nothing else

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::size_t missing = dropped.load(std::memory_order_relaxed) - told_;
    if (missing > 0 &&
        Write(fmt::format("{:10} lines were not printed: the reader was too slow\n", missing))) {
      told_ += missing;
    }
    const std::string_view text(message.payload.data(), message.payload.size());
    static_cast<void>(
        Write(flags_.is_json() ? JsonLine(message, text) : fmt::format("{}\n", text)));
  }
  void flush_() override {}

  /// Waits for the reader until the log ends. @returns whether all was written.
  [[nodiscard]] bool Write(std::string_view text) {
    const auto ended = [this] { return ends.load(std::memory_order_relaxed); };
    while (!text.empty() && !gave_up_) {
      gave_up_ = !AwaitReader(STDOUT_FILENO, ended);
      if (gave_up_) break;
      const auto written =
          ::write(STDOUT_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
      if (written < 0 && errno != EINTR) return false;
      text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return text.empty();
  }

  const LogFlags& flags_;
  std::size_t told_ = 0;  ///< of dropped
  bool gave_up_ = false;
};

EventLog::EventLog(const LogFlags& flags)
    : flags_(flags),
      sink_(std::make_shared<Sink>(flags)),
      thread_(std::make_shared<spdlog::details::thread_pool>(1024, 1)),
      log_(std::make_shared<spdlog::async_logger>("events", sink_, thread_,
                                                  spdlog::async_overflow_policy::overrun_oldest)) {
  std::fflush(stdout);
}

EventLog::~EventLog() {
  sink_->ends = true;
  log_.reset();
  thread_.reset();  // joins
}

void EventLog::Put(std::string_view text) {
  log_->info(text.substr(0, text.find_last_not_of('\n') + 1));
  sink_->dropped.store(thread_->overrun_counter(), std::memory_order_relaxed);
}

void EventLog::Put(double at_s, std::string_view text) {
  flags_.is_json() ? Put(text) : Put(fmt::format("{:10.3f} s  {}", at_s, text));
}

void Say(std::FILE* stream, std::string_view text) noexcept {
  while (!text.empty() && AwaitReader(::fileno(stream), WasInterrupted)) {
    const std::size_t size = std::min<std::size_t>(text.size(), PIPE_BUF);
    static_cast<void>(std::fwrite(text.data(), 1, size, stream));
    std::fflush(stream);
    text.remove_prefix(size);
  }
}

void FinishOutput() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw EnvironmentError(
      "standard output cannot be written, so what it shows is not complete; it is closed, or its "
      "disk is full");
}

}  // namespace twin::cli
