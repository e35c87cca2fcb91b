#include "campaign/page_people.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/run/operator_page.h"

namespace twin::campaign {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMost = 5;  ///< browsers at a time
constexpr auto kHands = milliseconds(33);
/// Of the page's documents.
constexpr auto kSilence = milliseconds(2000);
constexpr auto kHelloTimeout = milliseconds(5000);
/// Wires of 25 ms, stale_after of 200 ms, some losses.
constexpr auto kReaches = milliseconds(600);
/// The base slows down from 0.5 m/s by 0.3 m/s^2, the hand sooner.
constexpr auto kEnds = std::chrono::seconds(10);
constexpr auto kRests = std::chrono::seconds(3);
constexpr double kStands = 0.05;  ///< rad/s and m/s

constexpr std::array<std::string_view, 6> kNames = {"mode",  "gripper", "frame",
                                                    "scale", "release", "end"};

/// What is no message.
constexpr std::array<std::string_view, 6> kNonsense = {
    "",
    "[]",
    R"({"type":"hands","axes":[1,2,3],"engaged":true,"sent_ms":0})",
    R"({"type":"press","button":"all"})",
    R"({"type":"hands","axes":[1e999,0,0,0,0,0],"engaged":true,"sent_ms":0})",
    R"({"type":"pause","on":1})"};

/// What every client may say, whatever it does.
constexpr std::array<std::string_view, 8> kIdle = {R"({"type":"shown"})",
                                                   R"({"type":"ping","sent_ms":5})",
                                                   R"({"type":"view","of":"scene"})",
                                                   R"({"type":"camera","number":1})",
                                                   R"({"type":"record","on":true})",
                                                   R"({"type":"recover"})",
                                                   R"({"type":"home"})",
                                                   R"({"type":"pause","on":false})"};

}  // namespace

/// One end of a connection.
class PeopleAtPage::Browser final : public page::Connection {
 public:
  Browser(PeopleAtPage& all, std::uint64_t number, Time came)
      : number(number), came(came), all_(all) {}

  void Send(page::SharedFrame frame) override {
    const std::string_view bytes = frame->bytes;
    if (has_gone) all_.Note(fmt::format("connection {} has gone, and is sent {}", number, bytes));
    if (!has_token && !bytes.starts_with(R"({"type":"refused")")) {
      all_.Note(fmt::format("connection {} showed no token, and is sent {}", number, bytes));
    }
    if (bytes.starts_with(R"({"type":"state")")) CheckState(bytes);
  }
  [[nodiscard]] std::size_t waiting() const noexcept override { return 0; }
  void Authenticate() override {
    if (!has_token) all_.Note(fmt::format("connection {} counts as known", number));
  }
  void Close(std::string_view reason) override {
    if (!may_be_closed) all_.Note(fmt::format("connection {} is closed: {}", number, reason));
    is_closed = true;
  }

  const std::uint64_t number;
  const Time came;
  bool has_token = false;
  bool may_be_closed = false;  ///< it has done what ends a connection
  bool is_closed = false;
  bool has_gone = false;

 private:
  void CheckState(std::string_view state) {
    const auto known = std::ranges::count_if(
        all_.browsers_, [](const auto& one) { return one->has_token && !one->has_gone; });
    const std::string right =
        fmt::format(R"({{"type":"state","operator":{},"clients":{},)", all_.operator_, known);
    if (!state.starts_with(right)) {
      all_.Note(fmt::format("not {}, but {}", right, state.substr(0, right.size())));
    }
  }

  PeopleAtPage& all_;
};

PeopleAtPage::PeopleAtPage(std::uint64_t seed, PageTalk& talk)
    : talk_(talk),
      dice_(~seed ^ 0x9A6EULL),
      ends_with_control_(dice_.Chance(0.2)),
      eagerness_(0.002 * dice_.Between(1, 10)),
      ends_from_(FromSeconds(dice_.Between(1, 12))) {
  page::OperatorServerCallbacks calls{.status = [] { return R"("t":0)"; },
                                      .now = [this] { return clock_.now; }};
  if (ends_with_control_) calls.control = [](bool /*takes*/) {};
  server_.emplace(page::OperatorServerConfig{.token = "secret", .welcome = R"("title":"x")"},
                  std::move(calls), channel_, clock_);
}

PeopleAtPage::~PeopleAtPage() {
  for (const auto& browser : browsers_) browser->may_be_closed = true;
  server_->End("the run is over", page::RunEnd::kDone);
  for (const auto& browser : browsers_) {
    if (!browser->has_gone && !browser->is_closed) {
      Note(fmt::format("connection {} outlives the run", browser->number));
    }
  }
}

void PeopleAtPage::Note(const std::string& text) {
  if (talk_.finding) return;
  talk_.finding = Finding{
      "page", fmt::format("at {:.3f} s: {}", ToSeconds(clock_.now.time_since_epoch()), text)};
}

std::optional<teleop::OperatorSample> PeopleAtPage::Read(Time now) noexcept {
  Act(now);
  const std::optional<teleop::OperatorSample> sample = device_.Read(now);
  if (!sample) return sample;
  CheckSample(*sample);
  if (!sent_ || now - *sent_ > milliseconds(60)) flows_ = now;
  sent_ = now;
  ++since_stop_;
  return sample;
}

void PeopleAtPage::CheckSample(const teleop::OperatorSample& sample) {
  const std::array<std::uint32_t, kButtons> presses = {
      sample.mode_presses,    sample.gripper_presses, sample.frame_presses, sample.scale_presses,
      sample.release_presses, sample.end_presses,     sample.stop_presses};
  const bool moves = std::ranges::any_of(axes_, [](double x) { return x != 0; });
  const bool same_joint = sample.joint == joint_ || !moves;
  if (sample.axes == axes_ && sample.engaged == engaged_ && same_joint && presses == presses_) {
    return;
  }
  Note(fmt::format(
      "operator {} sent axes {} of joint {}, engaged {}, presses {}; the robot gets {}, {}, {}, {}",
      operator_, axes_, joint_, engaged_, presses_, sample.axes, sample.joint, sample.engaged,
      presses));
}

void PeopleAtPage::Feel(const teleop::OperatorFeedback& feedback) noexcept {
  const Time now = clock_.now;
  if (feedback.stopped && presses_[kStop] == 0) Note("stopped, and nobody pressed it");
  constexpr std::uint64_t kSome = 6;  // one of them is not lost
  if (stopped_ && now - *stopped_ > kReaches && since_stop_ > kSome && sent_ &&
      now - *sent_ < milliseconds(100) && !feedback.stopped) {
    Note(
        fmt::format("somebody pressed the emergency stop at {:.3f} s, and the robot is not stopped",
                    ToSeconds(stopped_->time_since_epoch())));
  }
  if (sent_ && now - *sent_ > kReaches && !feedback.holding) Note("nobody leads, and it holds not");
  if (sent_ && now - *sent_ < milliseconds(60) && now - flows_ > 2 * kReaches && feedback.holding) {
    Note("somebody leads, and it holds");
  }
  if (!feedback.stopped && !feedback.holding) {
    still_.reset();
  } else if (!still_) {
    still_ = now;
  }
  talk_.must_stand = still_ && now - *still_ > kRests;
  if (ended_ && now - *ended_ > kEnds) Note("the session was ended ten seconds ago, and goes on");
  device_.Feel(feedback);
}

void PeopleAtPage::Act(Time now) {
  clock_.now = now;
  if (dice_.Chance(eagerness_)) Come();
  for (std::size_t i = 0; i < browsers_.size(); ++i) {
    if (!browsers_[i]->has_gone && dice_.Chance(eagerness_)) ActAs(*browsers_[i]);
  }
  const auto leads = std::ranges::find_if(browsers_, [this](const auto& browser) {
    return !browser->has_gone && browser->number == operator_;
  });
  if (leads != browsers_.end() && now >= next_hands_ && now >= silent_until_) {
    next_hands_ = now + kHands;
    MoveHands(**leads);
  }
  if (now >= ends_from_) EndSession();
  Tick();
}

void PeopleAtPage::Come() {
  const auto there =
      std::ranges::count_if(browsers_, [](const auto& one) { return !one->has_gone; });
  if (there >= static_cast<std::ptrdiff_t>(kMost)) return;
  Connect();
}

PeopleAtPage::Browser& PeopleAtPage::Connect() {
  browsers_.push_back(std::make_unique<Browser>(*this, browsers_.size() + 1, clock_.now));
  server_->OnConnect(*browsers_.back());
  return *browsers_.back();
}

void PeopleAtPage::Go(Browser& browser, std::string_view why) {
  browser.has_gone = true;
  if (browser.number == operator_) LoseControl();
  server_->OnDisconnect(browser);
  if (!why.empty()) Note(fmt::format("connection {}: {}", browser.number, why));
}

void PeopleAtPage::LoseControl() {
  if (operator_ == 0) return;
  operator_ = 0;
  axes_ = {};
  engaged_ = false;
  if (!ends_with_control_) return;
  ++presses_[kEnd];
  if (!ended_) ended_ = clock_.now;
}

/// @post one that has done what ends a connection has gone.
void PeopleAtPage::Say(Browser& browser, const std::string& text) {
  server_->OnText(browser, text);
  if (!browser.may_be_closed) return;
  Go(browser, browser.is_closed ? "" : fmt::format("may go on after {}", text));
}

void PeopleAtPage::SayHello(Browser& browser, bool knows_token) {
  if (knows_token) {
    browser.has_token = true;
  } else {
    browser.may_be_closed = true;
  }
  Say(browser,
      fmt::format(R"({{"type":"hello","token":"{}"}})", knows_token ? "secret" : "Secret"));
}

void PeopleAtPage::Take(Browser& browser) {
  if (operator_ == 0) {
    operator_ = browser.number;
    heard_ = clock_.now;
  }
  Say(browser, R"({"type":"take"})");
}

void PeopleAtPage::MoveHands(Browser& browser) {
  Vector6 axes{};
  const int joint = dice_.Chance(0.05) ? dice_.Whole(1, kJoints) : 0;
  const bool engaged = !dice_.Chance(0.02);
  // Keys: held for a while, and let go.
  if (!dice_.Chance(0.1))
    axes = axes_;
  else if (dice_.Chance(0.7))
    axes[static_cast<std::size_t>(dice_.Whole(0, 5))] = dice_.Between(-1, 1);
  const Time now = clock_.now;
  if (browser.number == operator_) {
    axes_ = axes;
    joint_ = static_cast<std::uint8_t>(joint);
    engaged_ = engaged;
    heard_ = now;
    if (dice_.Chance(0.01)) silent_until_ = now + milliseconds(dice_.Whole(100, 3000));
  }
  Say(browser, fmt::format(R"({{"type":"hands","axes":[{}],"joint":{},"engaged":{},"sent_ms":{}}})",
                           fmt::join(axes, ","), joint, engaged,
                           now.time_since_epoch().count() / 1'000'000));
}

void PeopleAtPage::Press(Browser& browser, Button button) {
  if (browser.number == operator_) {
    ++presses_[button];
    if (button == kRelease) stopped_.reset();
    if (button == kEnd && !ended_) ended_ = clock_.now;
  }
  Say(browser, fmt::format(R"({{"type":"press","button":"{}"}})", kNames[button]));
}

void PeopleAtPage::Stop(Browser& browser) {
  ++presses_[kStop];
  axes_ = {};
  if (!stopped_) {
    stopped_ = clock_.now;
    since_stop_ = 0;
  }
  Say(browser, R"({"type":"stop"})");
}

void PeopleAtPage::ActAs(Browser& browser) {
  const auto any = [this](const auto& texts) {
    return std::string(texts[static_cast<std::size_t>(dice_.Whole(0, std::ssize(texts) - 1))]);
  };
  if (!browser.has_token) {
    if (dice_.Chance(0.8)) return SayHello(browser, dice_.Chance(0.85));
    browser.may_be_closed = true;
    return Say(browser, dice_.Chance(0.5) ? any(kIdle) : std::string(R"({"type":"stop"})"));
  }
  switch (dice_.Whole(0, 9)) {
    case 0:
    case 1:
    case 2: return Take(browser);
    case 3:
      if (browser.number == operator_ && dice_.Chance(0.5))
        LoseControl();
      else
        return Say(browser, any(kIdle));
      return Say(browser, R"({"type":"give_back"})");
    case 4:
      if (browser.number != operator_) MoveHands(browser);
      return;
    case 5:
    case 6: return Press(browser, static_cast<Button>(dice_.Whole(kMode, kRelease)));
    case 7:
      if (dice_.Chance(0.2)) Stop(browser);
      return;
    case 8:
      if (dice_.Chance(0.2)) Go(browser, "");
      return;
    default:
      if (!dice_.Chance(0.1)) return Say(browser, any(kIdle));
      browser.may_be_closed = true;
      return Say(browser, any(kNonsense));
  }
}

/// Somebody comes and does so, or whoever operates does.
void PeopleAtPage::EndSession() {
  if (ended_) return;
  if (operator_ == 0) {
    Browser& last = Connect();
    SayHello(last, true);
    Take(last);
  }
  for (const auto& browser : browsers_) {
    if (browser->number == operator_) return Press(*browser, kEnd);
  }
}

void PeopleAtPage::Tick() {
  const Time now = clock_.now;
  for (const auto& browser : browsers_) {
    if (!browser->has_token && now - browser->came > kHelloTimeout) browser->may_be_closed = true;
  }
  if (operator_ != 0 && now - heard_ > kSilence) LoseControl();
  server_->OnTick();
  for (const auto& browser : browsers_) {
    if (browser->may_be_closed && !browser->has_gone) {
      Go(*browser, browser->is_closed ? "" : "may stay without a token");
    }
  }
}

void StandWatch::Put(const record::CycleRecord& record) noexcept {
  if (next_ != nullptr) next_->Put(record);
  if (!talk_.must_stand || talk_.finding) return;
  const BaseTwist twist = record.base ? record.base->twist : BaseTwist{};
  const bool moves =
      std::ranges::any_of(record.state.dq, [](double dq) { return std::abs(dq) > kStands; }) ||
      std::abs(twist.v) > kStands || std::abs(twist.w) > kStands;
  if (!moves) return;
  talk_.finding = Finding{
      "page", fmt::format("cycle {}: stopped, or led by nobody, for seconds, and joints move at {} "
                          "rad/s, the base at {} m/s, {} rad/s",
                          record.state.message_id, record.state.dq, twist.v, twist.w)};
}

void StandWatch::Put(const record::TickRecord& record) noexcept {
  if (next_ != nullptr) next_->Put(record);
}

teleop::DeviceRegistry DevicesOfPeople(PageTalk& talk) {
  teleop::DeviceRegistry devices;
  devices.Add(std::string(run::kPageDevice), [&talk](const teleop::DeviceRequest& request) {
    return std::make_unique<PeopleAtPage>(request.seed, talk);
  });
  return devices;
}

}  // namespace twin::campaign
