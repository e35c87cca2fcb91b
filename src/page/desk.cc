#include "page/desk.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "twin/core/secret.h"

namespace twin::page {
namespace {

/// So many parcels may wait for a visitor before states and pictures are left out.
constexpr std::size_t kBehind = 4;

SharedParcel TextParcel(std::string text) {
  return std::make_shared<const Parcel>(Parcel{std::move(text), true});
}

void Refuse(Visitor& visitor, std::string_view why) {
  visitor.Send(TextParcel(fmt::format(R"({{"type":"refused","text":{}}})", Quoted(why))));
}

}  // namespace

Desk::Desk(DeskConfig config, DeskCalls calls, OperatorChannel& channel, const Clock& clock)
    : config_(std::move(config)), calls_(std::move(calls)), channel_(channel), clock_(clock) {}

Desk::Guest* Desk::Find(const Visitor& visitor) {
  const auto found = std::ranges::find(guests_, &visitor, &Guest::visitor);
  return found == guests_.end() ? nullptr : &*found;
}

void Desk::OnCome(Visitor& visitor) {
  guests_.push_back({.visitor = &visitor, .number = ++guests_so_far_, .came = clock_.Now()});
}

void Desk::OnText(Visitor& visitor, std::string_view text) {
  Guest* guest = Find(visitor);
  if (guest == nullptr) return;
  const std::optional<Message> said = ParseMessage(text);
  if (!said) {
    visitor.Close("that is no message of this page's");
  } else if (!guest->is_known && !std::holds_alternative<message::Hello>(*said)) {
    visitor.Close("the token comes first");
  } else {
    std::visit([&](const auto& what) { Obey(*guest, what); }, *said);
  }
}

void Desk::OnGone(Visitor& visitor) {
  const Guest* guest = Find(visitor);
  if (guest == nullptr) return;
  const bool operated = IsOperator(*guest);
  guests_.erase(guests_.begin() + (guest - guests_.data()));
  if (operated) EndControl("the operator's browser has gone");
}

void Desk::OnTick() {
  const Time now = clock_.Now();
  for (const Guest& guest : guests_) {
    if (!guest.is_known && now - guest.came > config_.hello_timeout) {
      guest.visitor->Close("no token came");
    }
  }
  if (operator_ != 0 && now - heard_ > config_.silence) {
    EndControl("nothing was heard of the operator's browser");
  }
  if (calls_.watched) {
    calls_.watched(std::ranges::any_of(
        guests_, [](const Guest& guest) { return guest.is_known && guest.awaits_picture; }));
  }
  if (now < next_state_) return;
  next_state_ = std::max(next_state_ + config_.state_period, now);
  SendState();
}

void Desk::OnPicture(const SharedParcel& picture) {
  for (Guest& guest : guests_) {
    if (!guest.is_known || !guest.awaits_picture || guest.visitor->waiting() >= kBehind) continue;
    guest.awaits_picture = false;
    guest.visitor->Send(picture);
  }
}

void Desk::Tell(Time at, std::string_view kind, std::string_view text) {
  events_.push_back(fmt::format(R"({{"type":"event","t":{:.3f},"kind":{},"text":{}}})",
                                ToSeconds(at.time_since_epoch()), Quoted(kind), Quoted(text)));
  if (events_.size() > kMostEvents) events_.pop_front();
  Broadcast(events_.back());
}

void Desk::End(std::string_view text) {
  EndControl("the run is over");
  Broadcast(fmt::format(R"({{"type":"end","text":{}}})", Quoted(text)));
  for (const Guest& guest : guests_) guest.visitor->Close("the run is over");
}

void Desk::Obey(Guest& guest, const message::Hello& hello) {
  if (!IsSameSecret(hello.token, config_.token)) {
    Refuse(*guest.visitor, "that is not the token this run has printed");
    guest.visitor->Close("wrong token");
    return;
  }
  if (guest.is_known) return;
  guest.is_known = true;
  guest.visitor->Trust();
  guest.awaits_picture = true;
  guest.visitor->Send(TextParcel(fmt::format(
      R"({{"type":"welcome","you":{},"watch_only":{},"may_record":{},{}}})", guest.number,
      Quoted(config_.watch_only), static_cast<bool>(calls_.record), config_.welcome)));
  for (const std::string& event : events_) guest.visitor->Send(TextParcel(event));
}

void Desk::Obey(Guest& guest, const message::TakeControl& /*take*/) {
  if (!config_.watch_only.empty()) {
    Refuse(*guest.visitor, config_.watch_only);
  } else if (operator_ == 0) {
    operator_ = guest.number;
    heard_ = clock_.Now();
    if (calls_.control) calls_.control(true);
    Tell(heard_, "control", fmt::format("visitor {} operates", guest.number));
  } else if (!IsOperator(guest)) {
    Refuse(*guest.visitor, fmt::format("visitor {} operates; one at a time", operator_));
  }
}

void Desk::Obey(Guest& guest, const message::GiveControlBack& /*back*/) {
  if (IsOperator(guest)) EndControl("given back");
}

void Desk::Obey(Guest& guest, const message::Hands& hands) {
  if (!IsOperator(guest)) return;  // a last one, after control was taken away, is no breach
  heard_ = clock_.Now();
  Publish(hands.axes, hands.engaged, hands.sent_ms);
}

void Desk::Obey(Guest& guest, const message::Press& press) {
  using message::Button;
  if (!IsOperator(guest)) {
    Refuse(*guest.visitor, "take control first");
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

void Desk::Obey(Guest& guest, const message::Stop& /*stop*/) {
  ++sample_.stop_presses;
  Publish({}, sample_.engaged, sent_ms_[sample_.sequence % kEchoes]);
  if (calls_.stop) calls_.stop();
  Tell(clock_.Now(), "stop", fmt::format("visitor {} pressed the emergency stop", guest.number));
}

void Desk::Obey(Guest& guest, const message::ChooseCamera& camera) {
  if (operator_ != 0 && !IsOperator(guest)) {
    Refuse(*guest.visitor, "there is one camera for all, and the operator points it");
  } else if (calls_.choose_camera) {
    calls_.choose_camera(camera.number);
  }
}

void Desk::Obey(Guest& guest, const message::PictureShown& /*shown*/) {
  guest.awaits_picture = true;
}

void Desk::Obey(Guest& guest, const message::Ping& ping) {
  guest.visitor->Send(
      TextParcel(fmt::format(R"({{"type":"pong","sent_ms":{:.3f}}})", ping.sent_ms)));
}

void Desk::Obey(Guest& guest, const message::Record& record) {
  if (!calls_.record) {
    Refuse(*guest.visitor, "nothing is recorded here");
  } else if (!IsOperator(guest)) {
    Refuse(*guest.visitor, "take control first: what the operator does is recorded");
  } else {
    Tell(clock_.Now(), "record", calls_.record(record.on));
  }
}

void Desk::EndControl(std::string_view why) {
  if (operator_ == 0) return;
  const std::uint64_t number = std::exchange(operator_, 0);
  if (calls_.control) {
    calls_.control(false);
    ++sample_.end_presses;
  }
  Publish({}, false, 0);
  Tell(clock_.Now(), "control", fmt::format("visitor {} operates no more: {}", number, why));
}

void Desk::Publish(const Vector6& axes, bool engaged, double sent_ms) {
  ++sample_.sequence;
  sample_.at = clock_.Now();
  sample_.axes = axes;
  sample_.engaged = engaged;
  sent_ms_[sample_.sequence % kEchoes] = sent_ms;
  channel_.Publish(sample_);
  if (calls_.sample) calls_.sample(sample_);
}

void Desk::SendState() {
  if (guests_.empty()) return;
  const SharedParcel state = TextParcel(StateText());
  for (const Guest& guest : guests_) {
    if (guest.is_known && guest.visitor->waiting() < kBehind) guest.visitor->Send(state);
  }
}

void Desk::Broadcast(std::string text) {
  const SharedParcel parcel = TextParcel(std::move(text));
  for (const Guest& guest : guests_) {
    if (guest.is_known) guest.visitor->Send(parcel);
  }
}

std::string Desk::StateText() {
  const auto known = std::ranges::count_if(guests_, &Guest::is_known);
  return fmt::format(R"({{"type":"state","operator":{},"visitors":{},"teleop":{},{}}})", operator_,
                     known, TeleopText(), calls_.status());
}

std::string Desk::TeleopText() {
  const teleop::OperatorFeedback* feedback = channel_.Feedback();
  if (feedback == nullptr) return "null";
  const bool has_echo = feedback->echo != 0 && sample_.sequence - feedback->echo < kEchoes;
  return fmt::format(
      R"({{"mode":"{}","stopped":{},"holding":{},"hand_closed":{},"fine":{},"at_border":{},"wrench":[{:.4g}],"echo_ms":{}}})",
      feedback->mode == teleop::Mode::kArm ? "arm" : "base", feedback->stopped, feedback->holding,
      feedback->hand_closed, feedback->fine, feedback->at_border, fmt::join(feedback->wrench, ","),
      has_echo ? fmt::format("{:.1f}", sent_ms_[feedback->echo % kEchoes]) : "null");
}

}  // namespace twin::page
