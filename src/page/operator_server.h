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

#include "page/connection.h"
#include "page/message.h"
#include "twin/core/clock.h"
#include "twin/core/time.h"
#include "twin/page/operator_channel.h"

namespace twin::page {

/// What clients are told, and what they may do.
struct OperatorServerConfig {
  std::string token;    ///< that each must know
  std::string welcome;  ///< members of a JSON object: what does not change
  /// Why nobody may operate here, for people; empty: one may.
  std::string watch_only{};
  Duration hello_timeout = std::chrono::seconds(5);  ///< until the token came
  Duration silence = std::chrono::seconds(2);        ///< after which control is taken away
  Duration state_period = std::chrono::milliseconds(40);
};

/// Callbacks of the operator server, called on its thread. Those marked optional may be empty.
struct OperatorServerCallbacks {
  std::function<std::string()> status;  ///< members of a JSON object: what is now
  /// An operator took control, or gave it back. Where this is set, the session's end is
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

/// Serves the operator's page: authenticates clients by the token, gives control to one of them at
/// a time, turns that client's input into samples, and broadcasts the state. Any client may stop.
///
/// Control: given to the first who asks while nobody has it; gone when it is given back, when the
/// connection is, and when no hands came for `silence`. Hands are the heartbeat: between them and
/// that, whoever reads the samples finds them too old, and holds.
///
/// Threads: the web server's.
class OperatorServer final : public ConnectionListener {
 public:
  /// @param channel, clock  must outlive this.
  OperatorServer(OperatorServerConfig config, OperatorServerCallbacks calls,
                 OperatorChannel& channel, const Clock& clock);

  void OnConnect(Connection& connection) override;
  void OnText(Connection& connection, std::string_view text) override;
  void OnDisconnect(Connection& connection) override;
  void OnTick() override;

  [[nodiscard]] std::size_t clients() const noexcept { return clients_.size(); }

  /// Sends it to the clients that have shown the last one.
  void OnPicture(const SharedFrame& picture);
  /// Sends a line to all clients, and to those that connect later.
  void Tell(Time at, std::string_view kind, std::string_view text);
  /// The run is over: tells all clients, and disconnects them.
  void End(std::string_view text);

 private:
  struct Client {
    Connection* connection = nullptr;
    std::uint64_t number = 0;  ///< from 1
    Time came{};
    bool is_authenticated = false;  ///< has sent the token
    bool awaits_picture = false;    ///< has shown the last one
  };

  void Handle(Client& client, const message::Hello& hello);
  void Handle(Client& client, const message::TakeControl& take);
  void Handle(Client& client, const message::GiveControlBack& back);
  void Handle(Client& client, const message::Hands& hands);
  void Handle(Client& client, const message::Press& press);
  void Handle(Client& client, const message::Stop& stop);
  void Handle(Client& client, const message::ChooseCamera& camera);
  void Handle(Client& client, const message::PictureShown& shown);
  void Handle(Client& client, const message::Ping& ping);
  void Handle(Client& client, const message::Record& record);

  [[nodiscard]] Client* Find(const Connection& connection);
  [[nodiscard]] bool IsOperator(const Client& client) const { return operator_ == client.number; }
  /// Ends the control, with all inputs at zero.
  void EndControl(std::string_view why);
  void Publish(const Vector6& axes, bool engaged, double sent_ms);
  void SendState();
  void Broadcast(std::string text);
  [[nodiscard]] std::string StateText();
  [[nodiscard]] std::string TeleopText();

  static constexpr std::size_t kEchoes = 256;  ///< a power of two: of samples under way
  static constexpr std::size_t kMostEvents = 30;

  const OperatorServerConfig config_;
  const OperatorServerCallbacks calls_;
  OperatorChannel& channel_;
  const Clock& clock_;
  std::vector<Client> clients_;
  std::uint64_t clients_so_far_ = 0;
  std::uint64_t operator_ = 0;  ///< number of the client in control; 0: none
  Time heard_{};                ///< the operator, last
  teleop::OperatorSample sample_;
  std::array<double, kEchoes> sent_ms_{};  ///< by the samples' sequence
  std::deque<std::string> events_;         ///< as sent, the last
  Time next_state_{};
};

}  // namespace twin::page
