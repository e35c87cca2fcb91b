#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/page_recording.h"
#include "twin/backend/registry.h"
#include "twin/core/time.h"
#include "twin/page/live_feed.h"
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"
#include "twin/scenario/robot_data.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::cli {

/// @throws InputError when an address is none, a port is out of range, or others could connect
/// without being named.
[[nodiscard]] page::PageSettings PageAt(const PageFlags& flags);

/// Before anything is done. @throws InputError as PageAt, and for flags of a page without --page.
void RequirePageFlags(const PageFlags& flags);

/// The cameras of a page: the scenario's, the hand's, and some round about.
[[nodiscard]] std::vector<page::NamedView> PageViews(const scenario::Scenario& scenario);

/// Says where the page is.
void TellPage(const page::LivePage& page, const PageFlags& flags);

/// The operator's page of a run, where the flags want one; else nothing, and all calls are without
/// effect.
///
/// Threads: one; the sink as LiveFeed.
class RunPage {
 public:
  /// @param records  the run's own sink. @param out  folder of its results.
  /// @param flags, records, interrupt  must outlive this.
  RunPage(const RunFlags& flags, rt::RecordSink& records, const InterruptGuard& interrupt,
          const std::filesystem::path& out);

  /// The program's devices and another one, "page": what the operator does there. Refers to this.
  [[nodiscard]] teleop::DeviceRegistry Devices(const run::Catalogue& catalogue);

  /// What the run's records go to.
  [[nodiscard]] rt::RecordSink* sink() noexcept;

  /// As long as it lives, the page is served; the run may then be gone.
  class [[nodiscard]] Opening {
   public:
    explicit Opening(RunPage& page) noexcept : page_(page) {}
    ~Opening() { page_.Close("it was broken off"); }
    Opening(const Opening&) = delete;
    Opening& operator=(const Opening&) = delete;

   private:
    RunPage& page_;
  };

  /// Begins to serve. @param connection  of a run that has not begun.
  /// @throws as PageAt and page::LivePage.
  Opening Open(const scenario::Scenario& scenario, const scenario::RobotData& robot,
               const backend::Connection& connection);

  /// @returns `own`, and the page is told too. @param own  may be empty.
  using Events = std::function<void(Time, std::string_view, std::string_view)>;
  [[nodiscard]] Events Also(Events own);

  /// Says how the run ended, and ends. More than once: no effect.
  void Close(std::string_view how);

 private:
  /// What one may do there. @param scenario  of the run.
  void Permit(const scenario::Scenario& scenario, page::PageSettings& settings);

  const PageFlags& flags_;
  const InterruptGuard& interrupt_;
  rt::RecordSink& records_;
  const MonotonicClock wall_;
  page::LiveFeed feed_;
  page::OperatorChannel channel_;
  PageRecording recording_;  ///< of the page's thread, while there is one
  std::unique_ptr<page::LivePage> page_;
};

}  // namespace twin::cli
