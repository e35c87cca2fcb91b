#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include <spdlog/logger.h>

namespace spdlog::details {
class thread_pool;
}

namespace twin::cli {

/// Flags of every command: what it tells beside its results.
struct LogFlags {
  bool verbose = false;
  bool quiet = false;
  std::string format = "text";  ///< or "json"
  [[nodiscard]] bool is_json() const noexcept { return format == "json"; }
};

/// Writes messages to standard error, each in one line: "panda-twin: warning: TEXT", or as JSON
/// {"level": "warning", "message": TEXT, "time": UTC}. Levels: debug (with verbose), info (called
/// note), warn and err. Flushes standard output first. Ignores what cannot be written.
///
/// Threads: any; may wait for the reader. Not real-time.
using Log = std::shared_ptr<spdlog::logger>;
/// @param flags  read at each message; must outlive the log.
[[nodiscard]] Log MakeLog(const LogFlags& flags);

/// Writes lines to standard output from a program that must not wait for its reader: a thread of
/// spdlog writes them. At most 1024 lines wait; then the oldest are dropped, and a line says how
/// many are missing.
///
/// Threads: any. Nothing else may write to standard output meanwhile.
class EventLog {
 public:
  /// @param flags  must outlive this. With json each text becomes {"message": TEXT, ...}.
  explicit EventLog(const LogFlags& flags);
  /// Writes what waits, as long as the reader takes something every 200 ms; drops the rest.
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// Never waits for a reader. @param text  whole lines.
  void Put(std::string_view text);
  /// An event. @param at_s  its time, s; in front of the text.
  void Put(double at_s, std::string_view text);

 private:
  class Sink;
  const LogFlags& flags_;
  const std::shared_ptr<Sink> sink_;
  std::shared_ptr<spdlog::details::thread_pool> thread_;
  std::shared_ptr<spdlog::logger> log_;
};

/// Writes `text` to `stream` (stdout, stderr), at once. A failure is ignored: a reader that went
/// away or a full disk must not end a run, nor the report of an error. Waits for a reader that
/// takes nothing until the user wants to end, and then drops the rest: such a reader must not keep
/// an arm moving.
void Say(std::FILE* stream, std::string_view text) noexcept;

/// For commands whose result is what they print: makes sure that it got out.
/// @throws EnvironmentError when any of it did not.
void FinishOutput();

}  // namespace twin::cli
