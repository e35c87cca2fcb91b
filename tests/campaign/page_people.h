#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "campaign/watch.h"
#include "conformance/dice.h"
#include "page/operator_server.h"
#include "twin/page/operator_channel.h"
#include "twin/page/page_device.h"
#include "twin/teleop/device.h"
#include "twin/teleop/device_registry.h"

namespace twin::campaign {

/// What people at a page and the robot make of each other.
struct PageTalk {
  std::optional<Finding> finding;  ///< the first violation
  bool must_stand = false;         ///< it was stopped, or nobody has led it, for seconds
};

/// People at an operator's page, in the robot's time: browsers come, show a token or a wrong one,
/// ask for control, lead, press buttons, fall silent, stop the robot, talk nonsense and leave, as
/// the seed draws. After some seconds whoever operates ends the session.
///
/// A second implementation of the page's rules (src/page/README.md) says what each may get, and
/// what the robot may get of each: README.md, invariant `page`.
///
/// Threads: the run's.
class PeopleAtPage final : public teleop::Device {
 public:
  /// @param talk  must outlive this.
  PeopleAtPage(std::uint64_t seed, PageTalk& talk);
  ~PeopleAtPage() override;

  std::optional<teleop::OperatorSample> Read(Time now) noexcept override;
  void Feel(const teleop::OperatorFeedback& feedback) noexcept override;
  [[nodiscard]] bool lost() const noexcept override { return false; }
  [[nodiscard]] std::string Describe() const override { return "people at a page"; }

 private:
  struct RunTime final : Clock {
    [[nodiscard]] Time Now() const noexcept override { return now; }
    Time now{};
  };
  class Browser;
  enum Button : std::uint8_t { kMode, kGripper, kFrame, kScale, kRelease, kEnd, kStop, kButtons };

  void Act(Time now);
  void Come();
  Browser& Connect();
  void Go(Browser& browser, std::string_view why);
  void ActAs(Browser& browser);
  void Say(Browser& browser, const std::string& text);
  void SayHello(Browser& browser, bool knows_token);
  void Take(Browser& browser);
  void MoveHands(Browser& browser);
  void Press(Browser& browser, Button button);
  void Stop(Browser& browser);
  void EndSession();
  void Tick();
  void LoseControl();
  void CheckSample(const teleop::OperatorSample& sample);
  void Note(const std::string& text);

  PageTalk& talk_;
  test::Dice dice_;
  const bool ends_with_control_;  ///< the session, once its operator has lost control
  const double eagerness_;        ///< events per ms
  const Time ends_from_;
  RunTime clock_;
  page::OperatorChannel channel_;
  page::PageDevice device_{channel_, "the campaign's", page::PageDevice::Presses::kAll};
  std::optional<page::OperatorServer> server_;
  std::vector<std::unique_ptr<Browser>> browsers_;  ///< also those that have gone

  // What the rules say.
  std::uint64_t operator_ = 0;  ///< 0: none
  Time heard_{};                ///< of the operator
  Vector6 axes_{};
  bool engaged_ = true;
  std::uint8_t joint_ = 0;
  std::array<std::uint32_t, kButtons> presses_{};

  Time silent_until_{};  ///< the operator's hands
  Time next_hands_{};
  std::optional<Time> stopped_;   ///< since
  std::optional<Time> ended_;     ///< the session, since
  std::optional<Time> sent_;      ///< the last sample that the robot was sent
  Time flows_{};                  ///< since when samples follow each other closely
  std::uint64_t since_stop_ = 0;  ///< samples that were sent
  std::optional<Time> still_;     ///< since when the robot says that it is stopped, or holds
};

/// Whether the robot stands when it must; passes all on.
///
/// Threads: the run's.
class StandWatch final : public record::RecordSink {
 public:
  /// @param next  may be null. All must outlive this.
  StandWatch(PageTalk& talk, record::RecordSink* next) : talk_(talk), next_(next) {}

  void Put(const record::CycleRecord& record) noexcept TWIN_REALTIME override;
  void Put(const record::TickRecord& record) noexcept TWIN_REALTIME override;

 private:
  PageTalk& talk_;
  record::RecordSink* const next_;
};

/// The page, of which each device has people of its own. @param talk  as PeopleAtPage's.
[[nodiscard]] teleop::DeviceRegistry DevicesOfPeople(PageTalk& talk);

}  // namespace twin::campaign
