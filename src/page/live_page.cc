#include "twin/page/live_page.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "page/live_camera.h"
#include "page/live_scene.h"
#include "page/message.h"
#include "page/operator_server.h"
#include "page/origin_check.h"
#include "page/own_addresses.h"
#include "page/site.h"
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

constexpr std::string_view kNoModel = "this process has no model of the robot";
constexpr std::string_view kMeasured =
    "Arm and base are shown where the robot measures them; the hand is shown open, and objects "
    "where the scenario puts them.";

/// Why browsers cannot draw the scene, for users; empty: they can.
std::string_view NoSceneReason(const PageScene& scene) {
  const bool is_simulated = scene.truth != nullptr && !scene.views.empty();
  if (!is_simulated && !scene.twin) return kNoModel;
  const auto files = Site();
  const bool has_library =
      std::ranges::find(files, "/three.module.min.js", &SiteFile::path) != files.end();
  return has_library ? ""
                     : "this panda-twin was built without three.js, which scripts/setup fetches";
}

std::string WelcomeOf(const PageSettings& settings, const PageScene& scene,
                      const std::optional<LiveScene>& drawn) {
  std::vector<std::string> cameras;
  for (const NamedView& view : scene.views) cameras.push_back(Quoted(view.name));
  const JointLimits& limits = settings.limits;
  return fmt::format(
      R"("title":{},"about":{},"report":{},"cameras":[{}],"scene":{},"no_scene":{},"limits":{{"q_min":[{:.5g}],"q_max":[{:.5g}],"dq_max":[{:.5g}]}})",
      Quoted(settings.title), Quoted(settings.about), Quoted(settings.report),
      fmt::join(cameras, ","), drawn ? drawn->description() : "null", Quoted(NoSceneReason(scene)),
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
        twin_(scene.twin),
        scene_(SceneOf(scene, feed)),
        operator_server_(ServerConfigOf(settings, scene), CallsOf(settings), channel, clock_),
        server_({.at = settings.at, .allow = settings.allow, .private_file = PrivateFileOf()},
                operator_server_) {
    if (scene.truth != nullptr && !scene.views.empty()) {
      camera_.emplace(
          scene.truth->model(), feed.scene(), scene.views,
          LiveCamera::Calls{.picture = [this](std::string bytes) { Show(std::move(bytes)); },
                            .failure = [this](std::string why) { TellNoPicture(std::move(why)); }});
    } else {
      status_.SetNoPicture(
          fmt::format("{}: there are no pictures",
                      scene.twin ? "this robot has no camera that the page knows" : kNoModel));
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

  void Tell(std::string_view kind, std::string_view text) {
    server_.Post([this, kind = std::string(kind), text = std::string(text)] {
      operator_server_.Tell(kind, text);
    });
  }

  void End(std::string_view text, RunEnd how) {
    if (!thread_.joinable()) return;
    server_.Post([this, how, text = std::string(text)] { operator_server_.End(text, how); });
    const Time until = clock_.Now() + kFarewell;
    while (ClientsLeft() > 0 && clock_.Now() < until) {
      rt::SleepUntil(clock_, clock_.Now() + std::chrono::milliseconds(20));
    }
    Stop();
  }

 private:
  [[nodiscard]] OperatorServerConfig ServerConfigOf(const PageSettings& settings,
                                                    const PageScene& scene) const {
    return {.token = token_,
            .welcome = WelcomeOf(settings, scene, scene_),
            .watch_only = settings.watch_only};
  }

  [[nodiscard]] std::optional<LiveScene> SceneOf(const PageScene& scene, LiveFeed& feed) {
    if (!NoSceneReason(scene).empty()) return {};
    if (scene.truth == nullptr) {
      return std::optional<LiveScene>(
          std::in_place, *twin_->model, [this] { return Measured(); }, render::View(), kMeasured);
    }
    return std::optional<LiveScene>(
        std::in_place, scene.truth->model(),
        [&scenes = feed.shown()] {
          return scenes.Refresh() ? std::optional(Placed{.at = scenes.value().at,
                                                         .qpos = scenes.value().Positions()})
                                  : std::nullopt;
        },
        scene.views.front().view, "");
  }

  /// The robot's model where it is measured, if it has moved on.
  [[nodiscard]] std::optional<Placed> Measured() {
    const ArmView* const arm = status_.arm();
    if (arm == nullptr || arm->at == measured_at_) return {};
    measured_at_ = arm->at;
    qpos_ = plant::PositionsAt(*twin_, arm->q);
    if (arm->base) plant::MoveBase(*twin_, arm->base->odometry, qpos_);
    return Placed{.at = arm->at, .qpos = qpos_};
  }

  [[nodiscard]] std::optional<PrivateFile> PrivateFileOf() const {
    if (!scene_) return {};
    return PrivateFile{.path = scene_->path(), .token = token_, .bytes = &scene_->file()};
  }

  [[nodiscard]] OperatorServerCallbacks CallsOf(const PageSettings& settings) {
    return {
        .status = [this] { return status_.Text(camera_ ? camera_->chosen() : 0); },
        .now = [this] { return status_.now(); },
        .control = settings.control,
        .release = settings.release,
        .stop = settings.stop,
        .choose_camera =
            [this](std::size_t number) {
              if (camera_) camera_->Choose(number);
            },
        .resume = settings.resume,
        .run_clock = settings.run_clock,
        .visited = [this] { visited_.store(true, std::memory_order_relaxed); },  // orders nothing
        .watched =
            [this](bool wanted) {
              if (camera_) camera_->Want(wanted);
            },
        .poses = [this] { return scene_ ? scene_->Poses() : std::string(); },
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
  const std::optional<plant::CompiledModel> twin_;
  std::optional<Time> measured_at_;
  std::vector<double> qpos_;
  std::optional<LiveScene> scene_;
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

void LivePage::Tell(std::string_view kind, std::string_view text) {
  impl_->Tell(kind, text);
}

void LivePage::End(std::string_view text, RunEnd how) {
  impl_->End(text, how);
}

}  // namespace twin::page
