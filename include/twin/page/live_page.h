#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "twin/backend/hand.h"
#include "twin/core/limits.h"
#include "twin/core/time.h"
#include "twin/fci/sockets.h"
#include "twin/page/live_feed.h"
#include "twin/page/operator_channel.h"
#include "twin/render/view.h"

namespace twin::page {

/// A camera that may be chosen.
struct NamedView {
  std::string name;
  render::View view;
};

/// Where the page is, what it is about, and what may be done there.
struct PageSettings {
  fci::Endpoint at{.address = 0x7f000001, .port = 8080};  ///< port 0: any free one
  std::optional<fci::Network> allow{};  ///< who may come from elsewhere; absent: nobody
  std::string title{};                  ///< the run's name
  std::string about{};                  ///< robot, drive, pace: a line
  JointLimits limits;                   ///< of the arm that is shown
  /// Why nobody may operate there, for people; empty: one may.
  std::string watch_only{};
  /// Emergency stop, beside the samples' (which the device tells); or empty. Called on the page's
  /// thread.
  std::function<void()> stop{};
  /// Its release, by the operator; as stop.
  std::function<void()> release{};
  /// Somebody operates now, or nobody does any more: then the session's end is pressed, too. Empty:
  /// a session goes on without an operator. Called on the page's thread.
  std::function<void(bool)> control{};
  /// Each sample of the operator's, as it goes to the device; or empty. Called on the page's
  /// thread.
  std::function<void(const teleop::OperatorSample&)> sample{};
  /// Begins or ends a recording of what the operator does. @returns a line for people, which begins
  /// with "recording" when one began. Empty: there is no such button. Called on the page's thread.
  std::function<std::string(bool)> record{};
};

/// What there is to see beside the arm. What is pointed to must outlive the page; null: it is not
/// there, or cannot be asked from another thread.
struct PageScene {
  const plant::TruthProbe* truth = nullptr;  ///< whose scenes the feed shows
  std::vector<NamedView> views{};            ///< of it; the first is looked through first
  const backend::Hand* hand = nullptr;
};

/// The operator's page of a run: server, camera and what they tell, on threads of their own.
/// src/page/README.md says how it is used, what it protects against and what goes over the wire.
///
/// Threads: one; Tell() from any. Not real-time; what is read of the run is read without disturbing
/// it (LiveFeed).
class LivePage {
 public:
  /// Serves from now on. @param feed, channel  must outlive this; they are of this page alone.
  /// @throws EnvironmentError when the port cannot be opened, or the system gives no random
  /// numbers.
  LivePage(const PageSettings& settings, const PageScene& scene, LiveFeed& feed,
           OperatorChannel& channel);
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  /// Where a browser finds it: "http://127.0.0.1:8080/#token=...", one for each address of this
  /// machine that it is served at, loopback last. What follows the # stays in the browser.
  [[nodiscard]] std::vector<std::string> urls() const;

  /// A line for all who look.
  void Tell(Time at, std::string_view kind, std::string_view text);
  /// The run is over: says so to all who look, and ends. More than once: no effect.
  void End(std::string_view text);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twin::page
