#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "twin/backend/hand.h"
#include "twin/core/clock.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/page/live_feed.h"
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"
#include "twin/record/cycle_record.h"
#include "twin/run/catalogue.h"
#include "twin/scenario/scenario.h"
#include "twin/teleop/device_registry.h"

namespace twin::run {

/// The device of scenarios that the operator leads from the page.
inline constexpr std::string_view kPageDevice = "page";

/// The operator's page of a run or of a served robot. Without an address all calls have no effect.
///
/// Threads: one; Tell() from any; the sink as page::LiveFeed.
class OperatorPage {
 public:
  using Events = std::function<void(Time, std::string_view kind, std::string_view text)>;

  /// @param at  address and port of the page; nullopt: no page.
  /// @param records  also receives the robot's records; may be null; must outlive this.
  /// @param folder  of the operator's recordings, operator_1.csv, operator_2.csv, ..., which device
  /// `script` replays. Created with the first recording.
  /// @param note  receives a line when a recording is incomplete or other machines reach the page.
  OperatorPage(std::optional<page::PageSettings> at, record::RecordSink* records,
               std::filesystem::path folder, std::function<void(std::string_view)> note);
  ~OperatorPage();
  OperatorPage(const OperatorPage&) = delete;
  OperatorPage& operator=(const OperatorPage&) = delete;

  [[nodiscard]] bool is_wanted() const noexcept { return settings_.has_value(); }
  /// Where the robot must send its records.
  [[nodiscard]] record::RecordSink* sink() noexcept { return is_wanted() ? &feed_ : records_; }
  [[nodiscard]] page::OperatorChannel& channel() noexcept { return channel_; }

  /// The catalogue's devices and kPageDevice, the operator's input on the page. Refers to this.
  [[nodiscard]] teleop::DeviceRegistry Devices(const Catalogue& catalogue);

  /// What the page shows. All must outlive it.
  struct Shown {
    const plant::TruthProbe* truth = nullptr;  ///< null: the robot is not simulated
    const backend::Hand* hand = nullptr;       ///< null: none, or it must not be asked
    /// Hold records back to the wall clock, which lets the page pause the run, until this is true;
    /// null: neither.
    const volatile bool* paced_until = nullptr;
    /// Without truth: as page::PageScene.
    std::optional<plant::CompiledModel> twin{};
  };
  /// Begins to serve. @param settings  actions and texts of the page; its address is ignored.
  /// @returns lines with the page's addresses. @throws as page::LivePage.
  [[nodiscard]] std::string Open(page::PageSettings settings, const scenario::Scenario& scenario,
                                 const Shown& shown);
  /// Puts what moves by itself where it is in the newest scene; nothing without Shown::truth.
  /// @param world  of the same scene. Threads: one other than the page's. @pre after Open().
  void Arrange(planning::CollisionWorld& world);
  /// Returns when the page has been opened in a browser, or `interrupted`. @pre is_wanted(), after
  /// Open().
  void AwaitVisitor(const volatile bool& interrupted) const;
  /// The settings of a page at which the operator's samples can be recorded.
  [[nodiscard]] page::PageSettings Recorded();

  /// @returns a function that calls `own` and shows the event. @param own  may be empty.
  [[nodiscard]] Events Also(Events own);
  /// Shows a line to all viewers.
  void Tell(std::string_view kind, std::string_view text);
  /// Shows how the run ended, and ends the page, which then reads nothing that it showed. A second
  /// call has no effect.
  void Close(std::string_view text, page::RunEnd how);

 private:
  class Recording;

  const std::optional<page::PageSettings> settings_;
  record::RecordSink* records_;
  const std::function<void(std::string_view)> note_;
  const MonotonicClock wall_;
  page::LiveFeed feed_;
  page::OperatorChannel channel_;
  const plant::TruthProbe* truth_ = nullptr;  ///< whose scenes the feed has
  std::unique_ptr<Recording> recording_;      ///< of the page's thread, while there is one
  std::unique_ptr<page::LivePage> page_;
};

}  // namespace twin::run
