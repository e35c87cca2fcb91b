#include "cli/run_page.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "cli/network.h"
#include "cli/picture.h"
#include "cli/run_records.h"
#include "cli/say.h"
#include "twin/core/error.h"

namespace twin::cli {
namespace {

render::View Around(const render::View& first, double azimuth_deg, double elevation_deg) {
  render::View view;
  view.orbit = first.orbit;
  view.orbit.azimuth_deg = azimuth_deg;
  view.orbit.elevation_deg = elevation_deg;
  return view;
}

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

std::vector<page::NamedView> PageViews(const scenario::RenderSection& render) {
  const render::View first = FilmOf(render).view;
  render::View hand;
  hand.kind = render::ViewKind::kGripper;
  return {{"the run's", first},
          {"the hand's", hand},
          {"from ahead", Around(first, 180, -15)},
          {"from the left", Around(first, -90, -15)},
          {"from above", Around(first, 180, -80)}};
}

void TellPage(const page::LivePage& page, const PageFlags& flags) {
  Say(stdout, fmt::format("page          {}\n", page.url()));
  if (flags.allow) {
    Say(stderr,
        "panda-twin: note: the page is reached from other machines, and what goes over this "
        "network is not encrypted: who listens learns the token\n");
  }
  std::fflush(stdout);
}

RunPage::RunPage(const PageFlags& flags, rt::RecordSink& records, const InterruptGuard& interrupt)
    : flags_(flags), interrupt_(interrupt), records_(records), feed_(&records) {}

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
  settings.watch_only = "nobody operates in this run; anyone may stop it";
  settings.stop = [this] { interrupt_.Interrupt(); };
  page::PageScene scene;
  const bool is_lockstep = scenario.drive == scenario::Drive::kLockstep;
  if (connection.truth != nullptr && RunRecords::CanFilm(*connection.truth)) {
    scene.truth = connection.truth;
    scene.views = PageViews(scenario.render);
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
