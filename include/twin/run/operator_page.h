#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "twin/backend/hand.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/page/live_feed.h"
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::run {

/// The device of scenarios that the operator leads from the page.
inline constexpr std::string_view kPageDevice = "page";

/// The operator's page of a run or of a served robot, when one is wanted; else all calls are
/// without effect.
///
/// Threads: one; Tell() from any; the sink as page::LiveFeed.
class OperatorPage {
 public:
  using Events = std::function<void(Time, std::string_view kind, std::string_view text)>;

  /// @param at  where it is served; nothing: there is no page.
  /// @param records  what the robot's records go to besides; may be null; must outlive this.
  /// @param folder  of recordings of what the operator does: operator_1.csv, operator_2.csv, ...,
  /// which device `script` runs again. Made when the first begins.
  /// @param note  told why a recording is not whole, and that others may reach the page.
  OperatorPage(std::optional<page::PageSettings> at, rt::RecordSink* records,
               std::filesystem::path folder, std::function<void(std::string_view)> note);
  ~OperatorPage();
  OperatorPage(const OperatorPage&) = delete;
  OperatorPage& operator=(const OperatorPage&) = delete;

  [[nodiscard]] bool is_wanted() const noexcept { return settings_.has_value(); }
  /// What the robot's records go to.
  [[nodiscard]] rt::RecordSink* sink() noexcept { return is_wanted() ? &feed_ : records_; }
  [[nodiscard]] page::OperatorChannel& channel() noexcept { return channel_; }

  /// The catalogue's devices and kPageDevice: what the operator does there. Refers to this.
  [[nodiscard]] teleop::DeviceRegistry Devices(const Catalogue& catalogue);

  /// What is to be seen. All must outlive the page.
  struct Shown {
    const plant::TruthProbe* truth = nullptr;  ///< null: nobody simulates the robot
    const backend::Hand* hand = nullptr;       ///< null: there is none, or it may not be asked
    bool keeps_pace = false;                   ///< records come no faster than the wall clock's
  };
  /// Begins to serve. @param settings  what may be done there, and its words; where it is, is
  /// known. @param scenario  of the robot.
  /// @returns lines with its addresses. @throws as page::LivePage.
  [[nodiscard]] std::string Open(page::PageSettings settings, const scenario::Scenario& scenario,
                                 const Shown& shown);
  /// The settings of a page at which the operator's samples can be recorded.
  [[nodiscard]] page::PageSettings Recorded();

  /// @returns `own`, and the page is told too. @param own  may be empty.
  [[nodiscard]] Events Also(Events own);
  /// A line for all who look.
  void Tell(Time at, std::string_view kind, std::string_view text);
  /// Says how it ended, and ends; looks at nothing that is shown from then on. More than once: no
  /// effect.
  void Close(std::string_view how);

 private:
  class Recording;

  const std::optional<page::PageSettings> settings_;
  rt::RecordSink* records_;
  const std::function<void(std::string_view)> note_;
  const MonotonicClock wall_;
  page::LiveFeed feed_;
  page::OperatorChannel channel_;
  std::unique_ptr<Recording> recording_;  ///< of the page's thread, while there is one
  std::unique_ptr<page::LivePage> page_;
};

}  // namespace twin::run
