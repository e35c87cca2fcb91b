#include "twin/run/operator_page.h"

#include <chrono>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"
#include "twin/page/page_device.h"
#include "twin/plant/observers.h"
#include "twin/rt/host_time.h"
#include "twin/run/film.h"
#include "twin/run/run_records.h"
#include "twin/teleop/recording_device.h"

namespace twin::run {
namespace {

/// From this side of what the run's own camera looks at; of a robot that drives, of itself and with
/// it as it turns.
render::View Around(const scenario::Scenario& scenario, double azimuth_deg, double elevation_deg) {
  render::View view;
  view.orbit = FilmOf(scenario.render).view.orbit;
  if (scenario.base) {
    view.kind = render::ViewKind::kTracking;
    view.name = "panda_link0";
    view.turns_along = true;
    view.orbit.lookat_m = {0.25, 0, 0.1};
    view.orbit.distance_m = 2.6;
  }
  view.orbit.azimuth_deg = azimuth_deg;
  view.orbit.elevation_deg = elevation_deg;
  return view;
}

/// The cameras of a page (prefix: of the arm's bodies): the scenario's, the hand's, and some round
/// about.
std::vector<page::NamedView> ViewsOf(const scenario::Scenario& scenario,
                                     const std::string& prefix) {
  render::View hand;
  hand.kind = render::ViewKind::kGripper;
  hand.name = prefix;
  return {{"the run's", FilmOf(scenario.render).view},
          {"from behind", Around(scenario, 0, -25)},
          {"the hand's", hand},
          {"from ahead", Around(scenario, 180, -15)},
          {"from the left", Around(scenario, -90, -15)},
          {"from above", Around(scenario, 0, -80)}};
}

}  // namespace

/// What the record button of the page does.
class OperatorPage::Recording {
 public:
  Recording(std::filesystem::path folder, page::OperatorChannel& channel,
            const std::function<void(std::string_view)>& note)
      : folder_(std::move(folder)), channel_(channel), note_(note) {}
  ~Recording() {
    if (recording_) static_cast<void>(End());
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// Begins or ends a recording. @returns one line on what happened, or on what went wrong.
  [[nodiscard]] std::string Switch(bool on);
  /// Keeps it, while a recording goes on.
  void Take(const teleop::OperatorSample& sample);

 private:
  [[nodiscard]] std::string Begin();
  [[nodiscard]] std::string End();

  const std::filesystem::path folder_;
  page::OperatorChannel& channel_;  ///< whose feedback tells in which mode a recording begins
  const std::function<void(std::string_view)>& note_;
  const MonotonicClock clock_;
  teleop::OperatorSample newest_;
  std::filesystem::path path_;  ///< of the recording that goes on
  std::unique_ptr<teleop::RecordingDevice> recording_;
};

std::string OperatorPage::Recording::Switch(bool on) {
  try {
    if (on && !recording_) return Begin();
    if (!on && recording_) return End();
  } catch (const Error& error) {
    recording_.reset();
    return fmt::format("nothing is recorded: {}", error.what());
  }
  return on ? fmt::format("recording goes on into {}", path_.string()) : "nothing was recorded";
}

void OperatorPage::Recording::Take(const teleop::OperatorSample& sample) {
  newest_ = sample;
  if (!recording_) return;
  if (const auto* feedback = channel_.Feedback()) recording_->Feel(*feedback);
  recording_->Record(sample, clock_.Now());
}

std::string OperatorPage::Recording::Begin() {
  std::error_code ignored;  // what cannot be made is told when the file is
  std::filesystem::create_directories(folder_, ignored);
  for (int i = 1;; ++i) {
    path_ = folder_ / fmt::format("operator_{}.csv", i);
    if (!std::filesystem::exists(path_, ignored)) break;
  }
  recording_ = std::make_unique<teleop::RecordingDevice>(nullptr, path_, note_, newest_);
  return fmt::format("recording what the operator does into {}", path_.string());
}

std::string OperatorPage::Recording::End() {
  const std::unique_ptr<teleop::RecordingDevice> recording = std::move(recording_);
  recording->Finish();
  return fmt::format("recorded: {}; device script runs it again", path_.string());
}

OperatorPage::OperatorPage(std::optional<page::PageSettings> at, record::RecordSink* records,
                           std::filesystem::path folder, std::function<void(std::string_view)> note)
    : settings_(std::move(at)),
      records_(records),
      note_(std::move(note)),
      feed_(records),
      recording_(std::make_unique<Recording>(std::move(folder), channel_, note_)) {}

OperatorPage::~OperatorPage() = default;

teleop::DeviceRegistry OperatorPage::Devices(const Catalogue& catalogue) {
  teleop::DeviceRegistry devices =
      catalogue.devices != nullptr ? *catalogue.devices : teleop::DeviceRegistry();
  devices.Add(std::string(kPageDevice),
              [this](const teleop::DeviceRequest& request) -> std::unique_ptr<teleop::Device> {
                if (!settings_) {
                  throw InputError(
                      "operator.device: page is the operator's page in a browser; run with --page");
                }
                auto device = std::make_unique<page::PageDevice>(
                    channel_, fmt::format("port {}", settings_->at.port),
                    page::PageDevice::Presses::kAll);
                const std::string file = request.parameters.Text("record", "");
                if (file.empty()) return device;
                return std::make_unique<teleop::RecordingDevice>(std::move(device),
                                                                 request.folder / file, note_);
              });
  return devices;
}

page::PageSettings OperatorPage::Recorded() {
  page::PageSettings settings;
  settings.sample = [this](const teleop::OperatorSample& sample) { recording_->Take(sample); };
  settings.record = [this](bool on) { return recording_->Switch(on); };
  return settings;
}

std::string OperatorPage::Open(page::PageSettings settings, const scenario::Scenario& scenario,
                               const Shown& shown) {
  if (!settings_) return {};
  settings.at = settings_->at;
  settings.allow = settings_->allow;
  page::PageScene scene;
  const plant::TruthProbe* const truth = shown.truth != nullptr ? &shown.truth->whole() : nullptr;
  if (truth != nullptr && RunRecords::CanFilm(*truth)) {
    scene.truth = truth;
    scene.views = ViewsOf(scenario, truth->prefix());
    feed_.Show(*truth);
    truth_ = truth;
  }
  if (shown.paced_until != nullptr) {
    feed_.KeepPace(wall_, shown.paced_until);
    settings.run_clock = {.is_paused = [this] { return feed_.is_paused(); },
                          .pause = [this](bool on) { feed_.Pause(on); },
                          .why_not = {}};
  }
  scene.hand = shown.hand;
  scene.twin = shown.twin;
  page_ = std::make_unique<page::LivePage>(settings, scene, feed_, channel_);
  if (settings.allow) {
    note_(
        "the page is reached from other machines, and what goes over this network is not "
        "encrypted: who listens learns the token");
  }
  std::string text;
  for (const std::string& url : page_->urls()) text += fmt::format("page          {}\n", url);
  return text;
}

void OperatorPage::Arrange(planning::CollisionWorld& world) {
  static_cast<void>(feed_.places().Refresh());
  if (truth_ == nullptr || !feed_.places().has_value()) return;
  world.ArrangeAs(truth_->model(), feed_.places().value().Positions());
}

void OperatorPage::AwaitVisitor(const volatile bool& interrupted) const {
  while (!page_->was_visited() && !interrupted) {
    rt::SleepUntil(wall_, wall_.Now() + std::chrono::milliseconds(50));
  }
}

OperatorPage::Events OperatorPage::Also(Events own) {
  if (!page_) return own;
  return [this, own = std::move(own)](Time at, std::string_view kind, std::string_view text) {
    if (own) own(at, kind, text);
    page_->Tell(kind, text);
  };
}

void OperatorPage::Tell(std::string_view kind, std::string_view text) {
  if (page_) page_->Tell(kind, text);
}

void OperatorPage::Close(std::string_view text, page::RunEnd how) {
  if (page_) page_->End(text, how);
}

}  // namespace twin::run
