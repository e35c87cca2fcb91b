#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/hand.h"
#include "twin/core/limits.h"
#include "twin/fci/sockets.h"
#include "twin/page/live_feed.h"
#include "twin/page/operator_channel.h"
#include "twin/plant/compiled_model.h"
#include "twin/render/view.h"

namespace twin::page {

/// How a run ended, for the page's viewers.
enum class RunEnd : std::uint8_t {
  kDone,
  kFailed,
};

/// What an operator's session does whose robot stays when the session ends.
enum class LedSession : std::uint8_t {
  kRests,     ///< none: before the first, or after a stop, an error or an end
  kConnects,  ///< it begins: connects and clears errors
  kLeads,
  kGoesHome,
};

/// Requests for the next session, of the operator in control. Called on the page's thread.
struct Resume {
  std::function<LedSession()> phase{};
  /// Clears the robot's errors and leads it on. @returns false unless it rests.
  std::function<bool()> recover{};
  /// The arm moves to its start by a planned way. @returns false unless it rests or leads; of one
  /// that leads, the end is pressed afterwards.
  std::function<bool()> home{};
};

/// The clock of a run that may stand still. Called on the page's thread.
struct RunClock {
  std::function<bool()> is_paused{};
  std::function<void(bool)> pause{};  ///< false: goes on
  /// Reason why there is no `pause`, for users; empty with it.
  std::string why_not = "the clock of this run cannot stand";
};

/// A selectable camera.
struct NamedView {
  std::string name;
  render::View view;
};

/// Address and content of the page, and the actions it permits.
struct PageSettings {
  fci::Endpoint at{.address = 0x7f000001, .port = 8080};  ///< port 0: any free port
  std::optional<fci::Network>
      allow{};          ///< remote network that may connect; absent: this machine only
  std::string title{};  ///< the run's name
  std::string about{};  ///< one line: robot, drive, pace
  JointLimits limits;   ///< of the displayed arm
  /// Reason why operation is disabled, for users; empty: enabled.
  std::string watch_only{};
  /// Emergency stop, in addition to the samples' (which the device reports); may be empty. Called
  /// on the page's thread.
  std::function<void()> stop{};
  /// The operator's release of the emergency stop; as stop.
  std::function<void()> release{};
  /// True: an operator has taken control. False: control has ended, and the session's end is
  /// pressed. Empty: a session continues without an operator. Called on the page's thread.
  std::function<void(bool)> control{};
  /// Without its functions: a session that ends is the last.
  Resume resume{};
  RunClock run_clock{};
  /// File of the report that the run leaves, for users; empty: none.
  std::string report{};
  /// Receives each of the operator's samples, as sent to the device; may be empty. Called on the
  /// page's thread.
  std::function<void(const teleop::OperatorSample&)> sample{};
  /// Starts or ends a recording of the operator's input. @returns a line for users; it begins with
  /// "recording" if one started. Empty: no such button. Called on the page's thread.
  std::function<std::string(bool)> record{};
};

/// Further sources for the page. Pointers must outlive the page; null: not present, or not readable
/// from another thread.
struct PageScene {
  const plant::TruthProbe* truth = nullptr;  ///< its scenes come through the feed
  std::vector<NamedView> views{};            ///< of truth's scene; the first is the default
  /// Without truth: model of the robot, shown where its joints are measured, with objects where the
  /// scene has them.
  std::optional<plant::CompiledModel> twin{};
  const backend::Hand* hand = nullptr;
};

/// The operator's page of a run: web server, camera and status, on threads of their own. See
/// docs/how-to/operator-page.md for usage and protection, src/page/README.md for the protocol.
///
/// Threads: one; Tell() from any. Not real-time; reads the run without disturbing it (LiveFeed).
class LivePage {
 public:
  /// Serves from construction. @param feed, channel  must outlive this object and have no other
  /// consumer.
  /// @throws EnvironmentError if the port cannot be opened, or the system gives no random numbers.
  LivePage(const PageSettings& settings, const PageScene& scene, LiveFeed& feed,
           OperatorChannel& channel);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  /// URLs for a browser: "http://127.0.0.1:8080/#token=...", one per served address of this
  /// machine, loopback last. The browser does not transmit the part after #.
  [[nodiscard]] std::vector<std::string> urls() const;

  /// Whether anyone has opened the page with its token. Any thread.
  [[nodiscard]] bool was_visited() const noexcept;

  /// Sends a line to all clients, at the time of the newest displayed state: one clock for all
  /// lines.
  void Tell(std::string_view kind, std::string_view text);
  /// The run has ended: notifies all clients and closes. Idempotent.
  void End(std::string_view text, RunEnd how);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::page
