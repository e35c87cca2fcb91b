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
#include "twin/page/live_page.h"
#include "twin/page/operator_channel.h"

namespace twin::page {

/// Configuration of the operator server.
struct OperatorServerConfig {
  std::string token;    ///< required of each client
  std::string welcome;  ///< members of a JSON object: constant data
  /// Reason why operation is disabled, for users; empty: enabled.
  std::string watch_only{};
  Duration hello_timeout = std::chrono::seconds(5);  ///< for the token
  Duration silence = std::chrono::seconds(2);        ///< after which the operator loses control
  Duration state_period = std::chrono::milliseconds(40);
};

/// Callbacks of the operator server, called on its thread. Those marked optional may be empty.
struct OperatorServerCallbacks {
  std::function<std::string()> status;  ///< members of a JSON object: current data
  std::function<Time()> now;            ///< of the run, as in `status`; stamps all events
  /// An operator took control or lost it. If set, the session's end is pressed when control is
  /// lost. Optional.
  std::function<void(bool)> control{};
  std::function<void()> release{};  ///< of an emergency stop, in addition to the device's; optional
  std::function<void()> stop{};     ///< emergency stop, in addition to the device's; optional
  std::function<void(std::size_t)> choose_camera{};  ///< optional
  Resume resume{};                                   ///< all its functions, or none
  RunClock run_clock{};                              ///< all its functions, or none
  std::function<void()> visited{};                   ///< a client has shown the token; optional
  std::function<void(bool)> watched{};               ///< true while a picture is wanted; optional
  /// Poses of the scene's bodies, for clients that draw it: members of a JSON object, or empty.
  /// Optional.
  std::function<std::string()> poses{};
  /// Receives each sample, as sent to the device; optional.
  std::function<void(const teleop::OperatorSample&)> sample{};
  /// Starts or ends a recording of the operator's input. @returns a line for users. Empty: not
  /// available.
  std::function<std::string(bool)> record{};
};

/// Serves the operator's page: authenticates clients by the token, gives control to one of them at
/// a time, turns that client's input into samples, and broadcasts the state. Any client may stop.
///
/// Control goes to the first client that asks while it is free. It ends when the client returns it,
/// disconnects, or sends no input for `silence`. Input is the heartbeat: between its loss and
/// `silence`, the reader finds the samples too old and holds.
///
/// Threads: the web server's.
class OperatorServer final : public ConnectionListener {
 public:
  /// @param channel, clock  must outlive this object.
  OperatorServer(OperatorServerConfig config, OperatorServerCallbacks calls,
                 OperatorChannel& channel, const Clock& clock);

  void OnConnect(Connection& connection) override;
  void OnText(Connection& connection, std::string_view text) override;
  void OnDisconnect(Connection& connection) override;
  void OnTick() override;

  [[nodiscard]] std::size_t clients() const noexcept { return clients_.size(); }

  /// Sends the picture to the clients that have displayed the last one.
  void OnPicture(const SharedFrame& picture);
  /// Sends a line to all clients, and to those that connect later.
  void Tell(std::string_view kind, std::string_view text);
  /// The run has ended: tells all clients and disconnects them.
  void End(std::string_view text, RunEnd how);

 private:
  struct Client {
    Connection* connection = nullptr;
    std::uint64_t number = 0;  ///< from 1
    Time came{};
    bool is_authenticated = false;  ///< has sent the token
    bool draws_scene = false;       ///< gets poses instead of pictures
    bool awaits_picture = false;    ///< has displayed the last picture
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
  void Handle(Client& client, const message::Recover& recover);
  void Handle(Client& client, const message::Home& home);
  void Handle(Client& client, const message::ChooseSight& choice);
  void Handle(Client& client, const message::Pause& pause);

  /// Refuses requests for another session, unless the client may make them.
  [[nodiscard]] bool MayResume(Client& client);
  [[nodiscard]] Client* Find(const Connection& connection);
  [[nodiscard]] bool IsOperator(const Client& client) const { return operator_ == client.number; }
  /// Ends the operator's control with all inputs at zero.
  void EndControl(std::string_view why);
  void Publish(const Vector6& axes, bool engaged, double sent_ms);
  void SendState();
  void SendPoses();
  void Broadcast(std::string text);
  [[nodiscard]] std::string StateText();
  [[nodiscard]] std::string TeleopText();

  static constexpr std::size_t kEchoes = 256;  ///< a power of two; samples whose echo is pending
  static constexpr std::size_t kMostEvents = 30;

  const OperatorServerConfig config_;
  const OperatorServerCallbacks calls_;
  OperatorChannel& channel_;
  const Clock& clock_;
  std::vector<Client> clients_;
  std::uint64_t clients_so_far_ = 0;
  std::uint64_t operator_ = 0;  ///< number of the client in control; 0: none
  Time heard_{};                ///< time of the operator's last input
  teleop::OperatorSample sample_;
  std::array<double, kEchoes> sent_ms_{};  ///< indexed by the samples' sequence
  std::deque<std::string> events_;         ///< the last ones, as sent
  Time next_state_{};
};

}  // namespace twin::page
