#include "cli/run_page.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/network.h"
#include "cli/picture.h"
#include "cli/run_records.h"
#include "cli/say.h"
#include "plugins/devices/recording_device.h"
#include "twin/core/error.h"
#include "twin/page/page_device.h"

namespace twin::cli {
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

constexpr std::string_view kPageDevice = "page";

std::string AboutOf(const scenario::Scenario& scenario) {
  const bool is_lockstep = scenario.drive == scenario::Drive::kLockstep;
  return fmt::format("{}, backend {}, drive {}{}", scenario.robot.model, scenario.backend,
                     Name(scenario.drive),
                     is_lockstep ? ", held back to the pace of the wall clock" : "");
}

}  // namespace

page::PageSettings PageAt(const PageFlags& flags) {
  std::uint16_t port = 0;
  const char* const end = flags.port.data() + flags.port.size();
  const auto [parsed, error] = std::from_chars(flags.port.data(), end, port);
  if (error != std::errc() || parsed != end) {
    throw InputError(fmt::format("--page is \"{}\"; it must be a port in [0, 65535]", flags.port));
  }
  const Listening listening = ListeningOf(flags.bind, flags.allow, "--page-bind", "--page-allow");
  page::PageSettings settings;
  settings.at = {.address = listening.address, .port = port};
  settings.allow = listening.allow;
  return settings;
}

void RequirePageFlags(const PageFlags& flags) {
  if (flags.wanted()) {
    static_cast<void>(PageAt(flags));
  } else if (flags.allow || flags.bind != PageFlags().bind) {
    throw InputError("--page-bind and --page-allow go with --page");
  }
}

std::vector<page::NamedView> PageViews(const scenario::Scenario& scenario) {
  render::View hand;
  hand.kind = render::ViewKind::kGripper;
  return {{"the run's", FilmOf(scenario.render).view},
          {"from behind", Around(scenario, 0, -25)},
          {"the hand's", hand},
          {"from ahead", Around(scenario, 180, -15)},
          {"from the left", Around(scenario, -90, -15)},
          {"from above", Around(scenario, 0, -80)}};
}

void TellPage(const page::LivePage& page, const PageFlags& flags) {
  for (const std::string& url : page.urls()) Say(stdout, fmt::format("page          {}\n", url));
  if (flags.allow) {
    Say(stderr,
        "panda-twin: note: the page is reached from other machines, and what goes over this "
        "network is not encrypted: who listens learns the token\n");
  }
  std::fflush(stdout);
}

RunPage::RunPage(const RunFlags& flags, rt::RecordSink& records, const InterruptGuard& interrupt,
                 const std::filesystem::path& out)
    : flags_(flags.page),
      interrupt_(interrupt),
      records_(records),
      feed_(&records),
      recording_(out, channel_) {}

teleop::DeviceRegistry RunPage::Devices(const run::Catalogue& catalogue) {
  teleop::DeviceRegistry devices =
      catalogue.devices != nullptr ? *catalogue.devices : teleop::DeviceRegistry();
  devices.Add(std::string(kPageDevice),
              [this](const teleop::DeviceRequest& request) -> std::unique_ptr<teleop::Device> {
                if (!flags_.wanted()) {
                  throw InputError(
                      "operator.device: page is the operator's page in a browser; run with --page");
                }
                auto device = std::make_unique<page::PageDevice>(channel_, "port " + flags_.port);
                const std::string file = request.parameters.Text("record", "");
                if (file.empty()) return device;
                return std::make_unique<devices::RecordingDevice>(
                    std::move(device), request.folder / file, &TellOfRecording);
              });
  return devices;
}

void RunPage::Permit(const scenario::Scenario& scenario, page::PageSettings& settings) {
  if (!scenario.operator_section || scenario.operator_section->device != kPageDevice) {
    settings.watch_only = "nobody operates this run from here; anyone may stop it";
    settings.stop = [this] { interrupt_.Interrupt(); };
    return;
  }
  settings.sample = [this](const teleop::OperatorSample& sample) { recording_.Take(sample); };
  settings.record = [this](bool on) { return recording_.Switch(on); };
}

rt::RecordSink* RunPage::sink() noexcept {
  if (!flags_.wanted()) return &records_;
  return &feed_;
}

RunPage::Opening RunPage::Open(const scenario::Scenario& scenario, const scenario::RobotData& robot,
                               const backend::Connection& connection) {
  if (!flags_.wanted()) return Opening(*this);
  page::PageSettings settings = PageAt(flags_);
  settings.title = scenario.name;
  settings.about = AboutOf(scenario);
  settings.limits = robot.limits;
  Permit(scenario, settings);
  page::PageScene scene;
  const bool is_lockstep = scenario.drive == scenario::Drive::kLockstep;
  if (connection.truth != nullptr && RunRecords::CanFilm(*connection.truth)) {
    scene.truth = connection.truth;
    scene.views = PageViews(scenario);
    feed_.Show(*connection.truth);
  }
  if (is_lockstep) {
    feed_.KeepPace(wall_);
  } else {
    scene.hand = connection.hand;  // lockstep has one thread, and the page is another
  }
  page_ = std::make_unique<page::LivePage>(settings, scene, feed_, channel_);
  TellPage(*page_, flags_);
  return Opening(*this);
}

RunPage::Events RunPage::Also(Events own) {
  if (!page_) return own;
  return [this, own = std::move(own)](Time at, std::string_view kind, std::string_view text) {
    if (own) own(at, kind, text);
    page_->Tell(at, kind, text);
  };
}

void RunPage::Close(std::string_view how) {
  if (!page_) return;
  page_->End(how);
  page_.reset();
}

}  // namespace twin::cli
