#include "page/operator_server.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/core/secret.h"

namespace twin::page {
namespace {

/// Queue length at which states and pictures are skipped for a connection.
constexpr std::size_t kBehind = 4;

SharedFrame TextFrame(std::string text) {
  return std::make_shared<const Frame>(Frame{std::move(text), true});
}

std::string_view SessionName(LedSession session) {
  switch (session) {
    case LedSession::kRests: return "rests";
    case LedSession::kConnects: return "connects";
    case LedSession::kLeads: return "leads";
    case LedSession::kGoesHome: break;
  }
  return "goes home";
}

void Refuse(Connection& connection, std::string_view why) {
  connection.Send(TextFrame(fmt::format(R"({{"type":"refused","text":{}}})", Quoted(why))));
}

}  // namespace

OperatorServer::OperatorServer(OperatorServerConfig config, OperatorServerCallbacks calls,
                               OperatorChannel& channel, const Clock& clock)
    : config_(std::move(config)), calls_(std::move(calls)), channel_(channel), clock_(clock) {}

OperatorServer::Client* OperatorServer::Find(const Connection& connection) {
  const auto found = std::ranges::find(clients_, &connection, &Client::connection);
  return found == clients_.end() ? nullptr : &*found;
}

void OperatorServer::OnConnect(Connection& connection) {
  clients_.push_back(
      {.connection = &connection, .number = ++clients_so_far_, .came = clock_.Now()});
}

void OperatorServer::OnText(Connection& connection, std::string_view text) {
  Client* client = Find(connection);
  if (client == nullptr) return;
  const std::optional<Message> said = ParseMessage(text);
  if (!said) {
    connection.Close("that is no message of this page's");
  } else if (!client->is_authenticated && !std::holds_alternative<message::Hello>(*said)) {
    connection.Close("the token comes first");
  } else {
    std::visit([&](const auto& what) { Handle(*client, what); }, *said);
  }
}

void OperatorServer::OnDisconnect(Connection& connection) {
  const Client* client = Find(connection);
  if (client == nullptr) return;
  const bool operated = IsOperator(*client);
  clients_.erase(clients_.begin() + (client - clients_.data()));
  if (operated) EndControl("the operator's browser has gone");
}

void OperatorServer::OnTick() {
  const Time now = clock_.Now();
  for (const Client& client : clients_) {
    if (!client.is_authenticated && now - client.came > config_.hello_timeout) {
      client.connection->Close("no token came");
    }
  }
  if (operator_ != 0 && now - heard_ > config_.silence) {
    EndControl("nothing was heard of the operator's browser");
  }
  if (calls_.watched) {
    calls_.watched(std::ranges::any_of(clients_, [](const Client& client) {
      return client.is_authenticated && client.awaits_picture;
    }));
  }
  if (now < next_state_) return;
  next_state_ = std::max(next_state_ + config_.state_period, now);
  SendState();
  SendPoses();
}

void OperatorServer::OnPicture(const SharedFrame& picture) {
  for (Client& client : clients_) {
    if (!client.is_authenticated || !client.awaits_picture ||
        client.connection->waiting() >= kBehind)
      continue;
    client.awaits_picture = false;
    client.connection->Send(picture);
  }
}

void OperatorServer::Tell(std::string_view kind, std::string_view text) {
  events_.push_back(fmt::format(R"({{"type":"event","t":{:.3f},"kind":{},"text":{}}})",
                                ToSeconds(calls_.now().time_since_epoch()), Quoted(kind),
                                Quoted(text)));
  if (events_.size() > kMostEvents) events_.pop_front();
  Broadcast(events_.back());
}

void OperatorServer::End(std::string_view text, RunEnd how) {
  EndControl("the run is over");
  Broadcast(fmt::format(R"({{"type":"end","text":{},"is_failure":{}}})", Quoted(text),
                        how == RunEnd::kFailed));
  for (const Client& client : clients_) client.connection->Close("the run is over");
}

void OperatorServer::Handle(Client& client, const message::Hello& hello) {
  if (!IsSameSecret(hello.token, config_.token)) {
    Refuse(*client.connection, "that is not the token this run has printed");
    client.connection->Close("wrong token");
    return;
  }
  if (client.is_authenticated) return;
  client.is_authenticated = true;
  client.connection->Authenticate();
  Handle(client, message::ChooseSight{hello.sight});
  if (calls_.visited) calls_.visited();
  client.connection->Send(TextFrame(fmt::format(
      R"({{"type":"welcome","you":{},"watch_only":{},"may_record":{},"may_resume":{},"no_pause":{},{}}})",
      client.number, Quoted(config_.watch_only), static_cast<bool>(calls_.record),
      static_cast<bool>(calls_.resume.phase), Quoted(calls_.run_clock.why_not), config_.welcome)));
  for (const std::string& event : events_) client.connection->Send(TextFrame(event));
}

void OperatorServer::Handle(Client& client, const message::TakeControl& /*take*/) {
  if (!config_.watch_only.empty()) {
    Refuse(*client.connection, config_.watch_only);
  } else if (operator_ == 0) {
    operator_ = client.number;
    heard_ = clock_.Now();
    if (calls_.control) calls_.control(true);
    Tell("control", fmt::format("connection {} operates", client.number));
  } else if (!IsOperator(client)) {
    Refuse(*client.connection, fmt::format("connection {} operates; one at a time", operator_));
  }
}

void OperatorServer::Handle(Client& client, const message::GiveControlBack& /*back*/) {
  if (IsOperator(client)) EndControl("given back");
}

void OperatorServer::Handle(Client& client, const message::Hands& hands) {
  if (!IsOperator(client)) return;  // a late message after losing control is legal
  heard_ = clock_.Now();
  sample_.joint = hands.joint;
  Publish(hands.axes, hands.engaged, hands.sent_ms);
}

void OperatorServer::Handle(Client& client, const message::Press& press) {
  using message::Button;
  if (!IsOperator(client)) {
    Refuse(*client.connection, "take control first");
    return;
  }
  switch (press.button) {
    case Button::kMode: ++sample_.mode_presses; break;
    case Button::kGripper: ++sample_.gripper_presses; break;
    case Button::kFrame: ++sample_.frame_presses; break;
    case Button::kScale: ++sample_.scale_presses; break;
    case Button::kRelease:
      ++sample_.release_presses;
      if (calls_.release) calls_.release();
      break;
    case Button::kEnd: ++sample_.end_presses; break;
  }
  Publish(sample_.axes, sample_.engaged, sent_ms_[sample_.sequence % kEchoes]);
}

void OperatorServer::Handle(Client& client, const message::Stop& /*stop*/) {
  ++sample_.stop_presses;
  Publish({}, sample_.engaged, sent_ms_[sample_.sequence % kEchoes]);
  if (calls_.stop) calls_.stop();
  if (calls_.run_clock.pause) calls_.run_clock.pause(false);  // the robot brakes at once
  Tell("stop", fmt::format("connection {} pressed the emergency stop", client.number));
}

void OperatorServer::Handle(Client& client, const message::ChooseCamera& camera) {
  if (operator_ != 0 && !IsOperator(client)) {
    Refuse(*client.connection, "there is one camera for all, and the operator points it");
  } else if (calls_.choose_camera) {
    calls_.choose_camera(camera.number);
  }
}

void OperatorServer::Handle(Client& client, const message::PictureShown& /*shown*/) {
  client.awaits_picture = !client.draws_scene;
}

void OperatorServer::Handle(Client& client, const message::ChooseSight& choice) {
  client.draws_scene = choice.sight == message::Sight::kScene;
  client.awaits_picture = !client.draws_scene;
}

void OperatorServer::Handle(Client& client, const message::Ping& ping) {
  client.connection->Send(
      TextFrame(fmt::format(R"({{"type":"pong","sent_ms":{:.3f}}})", ping.sent_ms)));
}

void OperatorServer::Handle(Client& client, const message::Record& record) {
  if (!calls_.record) {
    Refuse(*client.connection, "nothing is recorded here");
  } else if (!IsOperator(client)) {
    Refuse(*client.connection, "take control first: what the operator does is recorded");
  } else {
    Tell("record", calls_.record(record.on));
  }
}

bool OperatorServer::MayResume(Client& client) {
  if (!calls_.resume.phase) {
    Refuse(*client.connection, "this run leads its robot once; start it again");
    return false;
  }
  if (IsOperator(client)) return true;
  Refuse(*client.connection, "take control first");
  return false;
}

void OperatorServer::Handle(Client& client, const message::Recover& /*recover*/) {
  if (!MayResume(client) || calls_.resume.recover()) return;
  Refuse(*client.connection, "the robot is led already");
}

void OperatorServer::Handle(Client& client, const message::Home& /*home*/) {
  if (!MayResume(client)) return;
  const bool ends_first = calls_.resume.phase() == LedSession::kLeads;
  if (!calls_.resume.home()) {
    Refuse(*client.connection, "wait until the robot leads or rests");
  } else if (ends_first) {
    ++sample_.end_presses;
    Publish({}, sample_.engaged, 0);
  }
}

void OperatorServer::Handle(Client& client, const message::Pause& pause) {
  if (!calls_.run_clock.pause) {
    Refuse(*client.connection, calls_.run_clock.why_not);
  } else if (operator_ != 0 && !IsOperator(client)) {
    Refuse(*client.connection, "the operator pauses the run");
  } else {
    calls_.run_clock.pause(pause.on);
    Tell("clock",
         fmt::format("connection {} {} the run", client.number, pause.on ? "pauses" : "resumes"));
  }
}

void OperatorServer::EndControl(std::string_view why) {
  if (operator_ == 0) return;
  const std::uint64_t number = std::exchange(operator_, 0);
  if (calls_.control) {
    calls_.control(false);
    ++sample_.end_presses;
  }
  Publish({}, false, 0);
  Tell("control", fmt::format("connection {} operates no more: {}", number, why));
}

void OperatorServer::Publish(const Vector6& axes, bool engaged, double sent_ms) {
  ++sample_.sequence;
  sample_.at = clock_.Now();
  sample_.axes = axes;
  sample_.engaged = engaged;
  sent_ms_[sample_.sequence % kEchoes] = sent_ms;
  channel_.Publish(sample_);
  if (calls_.sample) calls_.sample(sample_);
}

void OperatorServer::SendState() {
  if (clients_.empty()) return;
  const SharedFrame state = TextFrame(StateText());
  for (const Client& client : clients_) {
    if (client.is_authenticated && client.connection->waiting() < kBehind)
      client.connection->Send(state);
  }
}

void OperatorServer::SendPoses() {
  const auto wants = [](const Client& client) {
    return client.is_authenticated && client.draws_scene && client.connection->waiting() < kBehind;
  };
  if (!calls_.poses || std::ranges::none_of(clients_, wants)) return;
  const std::string poses = calls_.poses();
  if (poses.empty()) return;
  const SharedFrame frame = TextFrame(fmt::format(R"({{"type":"poses",{}}})", poses));
  for (const Client& client : clients_) {
    if (wants(client)) client.connection->Send(frame);
  }
}

void OperatorServer::Broadcast(std::string text) {
  const SharedFrame frame = TextFrame(std::move(text));
  for (const Client& client : clients_) {
    if (client.is_authenticated) client.connection->Send(frame);
  }
}

std::string OperatorServer::StateText() {
  const auto known = std::ranges::count_if(clients_, &Client::is_authenticated);
  const std::string session =
      calls_.resume.phase ? Quoted(SessionName(calls_.resume.phase())) : std::string("null");
  const bool is_paused = calls_.run_clock.is_paused && calls_.run_clock.is_paused();
  return fmt::format(
      R"({{"type":"state","operator":{},"clients":{},"paused":{},"session":{},"teleop":{},{}}})",
      operator_, known, is_paused, session, TeleopText(), calls_.status());
}

std::string OperatorServer::TeleopText() {
  if (calls_.resume.phase && calls_.resume.phase() != LedSession::kLeads) return "null";
  const teleop::OperatorFeedback* feedback = channel_.Feedback();
  if (feedback == nullptr) return "null";
  const bool has_echo = feedback->echo != 0 && sample_.sequence - feedback->echo < kEchoes;
  return fmt::format(
      R"({{"mode":"{}","stopped":{},"holding":{},"awaits_release":{},"hand_closed":{},"fine":{},"joint":{},"at_border":{},"why":{},"wrench":[{:.4g}],"echo_ms":{}}})",
      feedback->mode == teleop::Mode::kArm ? "arm" : "base", feedback->stopped, feedback->holding,
      feedback->awaits_release, feedback->hand_closed, feedback->fine, feedback->joint,
      feedback->at_border, Quoted(teleop::Describe(feedback->limit)),
      fmt::join(feedback->wrench, ","),
      has_echo ? fmt::format("{:.1f}", sent_ms_[feedback->echo % kEchoes]) : "null");
}

}  // namespace twin::page
