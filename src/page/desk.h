#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "page/message.h"
#include "page/visitor.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/page/operator_channel.h"

namespace twin::page {

/// What visitors are told, and what they may do.
struct DeskConfig {
  std::string token;    ///< that each must know
  std::string welcome;  ///< members of a JSON object: what does not change
  /// Why nobody may operate here, for people; empty: one may.
  std::string watch_only{};
  Duration hello_timeout = std::chrono::seconds(5);  ///< until the token came
  Duration silence = std::chrono::seconds(2);        ///< after which control is taken away
  Duration state_period = std::chrono::milliseconds(40);
};

/// What the desk has others do. All are called on its thread; those marked may be empty.
struct DeskCalls {
  std::function<std::string()> status;  ///< members of a JSON object: what is now
  /// Somebody operates now; or nobody does any more. Where this is set, the session's end is
  /// pressed after the latter. Or empty.
  std::function<void(bool)> control{};
  std::function<void()> release{};  ///< of an emergency stop, beside the device's; or empty
  std::function<void()> stop{};     ///< emergency stop, beside the device's; or empty
  std::function<void(std::size_t)> choose_camera{};  ///< or empty
  std::function<void(bool)> watched{};               ///< whether a picture is wanted now; or empty
  /// Each sample, as it goes to the device; or empty.
  std::function<void(const teleop::OperatorSample&)> sample{};
  /// Begins or ends a recording of what the operator does. @returns a line for people. Or empty:
  /// that cannot be.
  std::function<std::string(bool)> record{};
};

/// Looks after the visitors: lets in who knows the token, gives control to one at a time, makes
/// samples of what that one's hands do, tells all what is. Anyone may stop.
///
/// Control: given to the first who asks while nobody has it; gone when it is given back, when the
/// connection is, and when no hands came for `silence`. Hands are the heartbeat: between them and
/// that, whoever reads the samples finds them too old, and holds.
///
/// Threads: the web server's.
class Desk final : public Visitors {
 public:
  /// @param channel, clock  must outlive this.
  Desk(DeskConfig config, DeskCalls calls, OperatorChannel& channel, const Clock& clock);

  void OnCome(Visitor& visitor) override;
  void OnText(Visitor& visitor, std::string_view text) override;
  void OnGone(Visitor& visitor) override;
  void OnTick() override;

  [[nodiscard]] std::size_t visitors() const noexcept { return guests_.size(); }

  /// To all who have shown the last one.
  void OnPicture(const SharedParcel& picture);
  /// A line for all, and for those who come later.
  void Tell(Time at, std::string_view kind, std::string_view text);
  /// The run is over: tells all, and lets them go.
  void End(std::string_view text);

 private:
  struct Guest {
    Visitor* visitor = nullptr;
    std::uint64_t number = 0;  ///< from 1
    Time came{};
    bool is_known = false;        ///< had the token
    bool awaits_picture = false;  ///< has shown the last one
  };

  void Obey(Guest& guest, const message::Hello& hello);
  void Obey(Guest& guest, const message::TakeControl& take);
  void Obey(Guest& guest, const message::GiveControlBack& back);
  void Obey(Guest& guest, const message::Hands& hands);
  void Obey(Guest& guest, const message::Press& press);
  void Obey(Guest& guest, const message::Stop& stop);
  void Obey(Guest& guest, const message::ChooseCamera& camera);
  void Obey(Guest& guest, const message::PictureShown& shown);
  void Obey(Guest& guest, const message::Ping& ping);
  void Obey(Guest& guest, const message::Record& record);

  [[nodiscard]] Guest* Find(const Visitor& visitor);
  [[nodiscard]] bool IsOperator(const Guest& guest) const { return operator_ == guest.number; }
  /// Nobody operates any more: hands off.
  void EndControl(std::string_view why);
  void Publish(const Vector6& axes, bool engaged, double sent_ms);
  void SendState();
  void Broadcast(std::string text);
  [[nodiscard]] std::string StateText();
  [[nodiscard]] std::string TeleopText();

  static constexpr std::size_t kEchoes = 256;  ///< a power of two: of samples under way
  static constexpr std::size_t kMostEvents = 30;

  const DeskConfig config_;
  const DeskCalls calls_;
  OperatorChannel& channel_;
  const Clock& clock_;
  std::vector<Guest> guests_;
  std::uint64_t guests_so_far_ = 0;
  std::uint64_t operator_ = 0;  ///< number of the guest in control; 0: nobody
  Time heard_{};                ///< the operator, last
  teleop::OperatorSample sample_;
  std::array<double, kEchoes> sent_ms_{};  ///< by the samples' sequence
  std::deque<std::string> events_;         ///< as sent, the last
  Time next_state_{};
};

}  // namespace twin::page
