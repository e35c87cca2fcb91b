#include "twin/page/live_page.h"

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "page/live_camera.h"
#include "page/message.h"
#include "page/operator_server.h"
#include "page/origin_check.h"
#include "page/own_addresses.h"
#include "page/status.h"
#include "page/web_server.h"
#include "twin/core/clock.h"
#include "twin/core/secret.h"
#include "twin/plant/truth_probe.h"
#include "twin/rt/host_time.h"
#include "twin/rt/thread_setup.h"

namespace twin::page {
namespace {

/// Timeout for telling the clients that the run has ended.
constexpr Duration kFarewell = std::chrono::seconds(1);

std::string WelcomeOf(const PageSettings& settings, const PageScene& scene) {
  std::vector<std::string> cameras;
  for (const NamedView& view : scene.views) cameras.push_back(Quoted(view.name));
  const JointLimits& limits = settings.limits;
  return fmt::format(
      R"("title":{},"about":{},"cameras":[{}],"limits":{{"q_min":[{:.5g}],"q_max":[{:.5g}],"dq_max":[{:.5g}]}})",
      Quoted(settings.title), Quoted(settings.about), fmt::join(cameras, ","),
      fmt::join(limits.q_min, ","), fmt::join(limits.q_max, ","), fmt::join(limits.dq_max, ","));
}

}  // namespace

class LivePage::Impl {
 public:
  Impl(const PageSettings& settings, const PageScene& scene, LiveFeed& feed,
       OperatorChannel& channel)
      : token_(MakeSecret(kTokenLetters)),
        channel_(channel),
        status_(settings.limits, scene, feed.arm()),
        operator_server_(ServerConfigOf(settings, scene), CallsOf(settings), channel, clock_),
        server_({.at = settings.at, .allow = settings.allow}, operator_server_) {
    if (scene.truth != nullptr && !scene.views.empty()) {
      camera_.emplace(
          scene.truth->model(), feed.scene(), scene.views,
          LiveCamera::Calls{.picture = [this](std::string bytes) { Show(std::move(bytes)); },
                            .failure = [this](std::string why) { TellNoPicture(std::move(why)); }});
    } else {
      status_.SetNoPicture("this process has no model of the robot: there are no pictures");
    }
    thread_ = std::jthread([this] {
      static_cast<void>(rt::SetUpThisThread({.name = "twin-page", .lock_memory = false}));
      server_.Run();
    });
  }

  ~Impl() { Stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] std::vector<std::string> urls() const {
    std::vector<std::string> urls;
    for (const std::uint32_t address : AddressesOf(server_.at().address)) {
      urls.push_back(
          fmt::format("http://{}/#token={}", fci::ToString({address, server_.at().port}), token_));
    }
    return urls;
  }

  [[nodiscard]] bool was_visited() const noexcept {
    return visited_.load(std::memory_order_relaxed);
  }

  void Tell(Time at, std::string_view kind, std::string_view text) {
    server_.Post([this, at, kind = std::string(kind), text = std::string(text)] {
      operator_server_.Tell(at, kind, text);
    });
  }

  void End(std::string_view text) {
    if (!thread_.joinable()) return;
    server_.Post([this, text = std::string(text)] { operator_server_.End(text); });
    const Time until = clock_.Now() + kFarewell;
    while (ClientsLeft() > 0 && clock_.Now() < until) {
      rt::SleepUntil(clock_, clock_.Now() + std::chrono::milliseconds(20));
    }
    Stop();
  }

 private:
  [[nodiscard]] OperatorServerConfig ServerConfigOf(const PageSettings& settings,
                                                    const PageScene& scene) const {
    return {
        .token = token_, .welcome = WelcomeOf(settings, scene), .watch_only = settings.watch_only};
  }

  [[nodiscard]] OperatorServerCallbacks CallsOf(const PageSettings& settings) {
    return {.status = [this] { return status_.Text(camera_ ? camera_->chosen() : 0); },
            .control = settings.control,
            .release = settings.release,
            .stop = settings.stop,
            .choose_camera =
                [this](std::size_t number) {
                  if (camera_) camera_->Choose(number);
                },
            .watched =
                [this](bool wanted) {
                  if (wanted) visited_.store(true, std::memory_order_relaxed);  // orders nothing
                  if (camera_) camera_->Want(wanted);
                },
            .sample = settings.sample,
            .record = settings.record};
  }

  void Show(std::string bytes) {
    server_.Post([this, picture = std::make_shared<const Frame>(Frame{std::move(bytes), false})] {
      operator_server_.OnPicture(picture);
    });
  }

  void TellNoPicture(std::string why) {
    server_.Post([this, why = std::move(why)]() mutable {
      status_.SetNoPicture("there are no pictures: " + std::move(why));
    });
  }

  [[nodiscard]] std::size_t ClientsLeft() {
    std::promise<std::size_t> left;
    std::future<std::size_t> answer = left.get_future();
    server_.Post([this, &left] { left.set_value(operator_server_.clients()); });
    return answer.get();
  }

  void Stop() {
    channel_.End();
    camera_.reset();
    server_.Stop();
    if (thread_.joinable()) thread_.join();
  }

  const MonotonicClock clock_;
  const std::string token_;
  OperatorChannel& channel_;
  std::atomic<bool> visited_{false};
  Status status_;  ///< from here on owned by the server's thread, once it runs
  OperatorServer operator_server_;
  WebServer server_;
  std::optional<LiveCamera> camera_;  ///< set before the server runs
  std::jthread thread_;
};

LivePage::LivePage(const PageSettings& settings, const PageScene& scene, LiveFeed& feed,
                   OperatorChannel& channel)
    : impl_(std::make_unique<Impl>(settings, scene, feed, channel)) {}

LivePage::~LivePage() = default;

bool LivePage::was_visited() const noexcept {
  return impl_->was_visited();
}

std::vector<std::string> LivePage::urls() const {
  return impl_->urls();
}

void LivePage::Tell(Time at, std::string_view kind, std::string_view text) {
  impl_->Tell(at, kind, text);
}

void LivePage::End(std::string_view text) {
  impl_->End(text);
}

}  // namespace twin::page
