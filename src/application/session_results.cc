#include "twin/application/session_results.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/record/recorder.h"
#include "twin/render/clip.h"
#include "twin/replay/recording.h"
#include "twin/report/explanation.h"
#include "twin/report/logged_motions.h"
#include "twin/report/page.h"
#include "twin/report/plots.h"
#include "twin/run/film.h"
#include "twin/run/run_records.h"
#include "twin/run/summary.h"

namespace twin::application {
namespace {

using nlohmann::json;
using report::LoggedMotion;
using report::LoggedSession;

/// Kept after a motion in its log, and in the film after the last movement.
constexpr Duration kAfterwards = std::chrono::milliseconds(500);

double SecondsOf(Time time) {
  return ToSeconds(time.time_since_epoch());
}

std::string KindOf(const LoggedMotion& motion) {
  return DescribeMotion(motion.generator, motion.controller);
}

/// Writes the logs of a session's motions, one after the other.
class LogSplitter {
 public:
  LogSplitter(const SessionInputs& inputs, const LoggedSession& session)
      : inputs_(inputs), session_(session) {}

  void Split() {
    record::LogReader reader(inputs_.out.log());
    record::LogEntry entry;
    while (reader.Next(entry) && motion_ < session_.motions.size()) {
      if (const auto* cycle = std::get_if<record::CycleRecord>(&entry)) {
        if (At(cycle->at)) Put(*cycle);
      } else if (const auto* scene = std::get_if<record::SceneRecord>(&entry)) {
        if (log_) log_->Put(*scene);
      }
    }
    if (log_) Next();
  }

 private:
  /// Begins and ends logs. @returns whether a motion's log holds this instant.
  bool At(Time now) {
    if (log_ && now >= Until()) Next();
    if (!log_ && motion_ < session_.motions.size() && now >= Motion().begin) Begin();
    return log_.has_value();
  }

  [[nodiscard]] const LoggedMotion& Motion() const { return session_.motions[motion_]; }
  [[nodiscard]] Time Until() const {
    const Time until = Motion().end + kAfterwards;
    const std::size_t next = motion_ + 1;
    return next < session_.motions.size() ? std::min(until, session_.motions[next].begin) : until;
  }

  void Begin() {
    const std::size_t number = motion_ + 1;
    const std::filesystem::path folder = inputs_.out.motion(number);
    run::MakeFolder(folder);
    record::RunInfo info = run::InfoOf(inputs_.scenario, inputs_.robot);
    info.scenario += fmt::format(", motion {}", number);
    log_.emplace(run::ResultFolder(folder).log(), info, record::FullRing::kWait);
    log_->Event(Motion().begin, "session", fmt::format("motion {}: {}", number, KindOf(Motion())));
    events_ =
        std::ranges::lower_bound(session_.events, Motion().begin, {}, &record::EventRecord::at) -
        session_.events.begin();
  }

  void Put(const record::CycleRecord& cycle) {
    for (; const record::EventRecord* event = EventUntil(cycle.at); ++events_) {
      // What the arm touched is told after the cycle of the error.
      if (event->at == cycle.at && event->kind == "contact") break;
      // In its first cycle the end of the motion before may be told.
      if (!TellsAnEnd(*event) || event->at != Motion().begin) Put(*event);
    }
    log_->Put(cycle);
  }

  void Put(const record::EventRecord& event) { log_->Event(event.at, event.kind, event.text); }

  /// The next event, unless it is later than `last`; else null.
  [[nodiscard]] const record::EventRecord* EventUntil(Time last) const {
    if (events_ == std::ssize(session_.events)) return nullptr;
    const record::EventRecord& next = session_.events[static_cast<std::size_t>(events_)];
    return next.at > last ? nullptr : &next;
  }

  [[nodiscard]] static bool TellsAnEnd(const record::EventRecord& event) {
    return event.kind == "motion" && !event.text.starts_with("started");
  }

  void Next() {
    // Its end may be told at the instant at which the next one begins.
    const Time until = Until();
    for (; const record::EventRecord* event = EventUntil(until); ++events_) {
      if (event->at < until || TellsAnEnd(*event)) Put(*event);
    }
    static_cast<void>(log_->Finish());
    log_.reset();
    ++motion_;
  }

  const SessionInputs& inputs_;
  const LoggedSession& session_;
  std::size_t motion_ = 0;
  std::ptrdiff_t events_ = 0;
  std::optional<record::Recorder> log_;  ///< of motion_, while it is written
};

/// What the page says of a motion beside its record.
struct MotionFiles {
  std::string explanation;
  bool has_page = false;
  std::vector<std::filesystem::path> plots{};
  std::string film{};  ///< second of the video at which it begins: "12.30"; empty: not in it
};

/// A film of a session without the times at which nothing moves.
class SessionFilm {
 public:
  explicit SessionFilm(const render::Snapshots& scenes) : shown_(scenes.fps(), scenes.qpos_size()) {
    // A body that settles creeps less than this per frame, m or rad.
    constexpr double kStill = 1e-5;
    Time moved = scenes.time(0);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const bool moves =
          i > 0 && !std::ranges::equal(scenes.qpos(i), scenes.qpos(i - 1),
                                       [](double a, double b) { return std::abs(a - b) < kStill; });
      if (moves) moved = scenes.time(i);
      if (scenes.time(i) <= moved + kAfterwards) shown_.Append(scenes.scene(i));
    }
  }

  [[nodiscard]] const render::Snapshots& shown() const noexcept { return shown_; }

  /// The second of the video at which an instant of the session is shown.
  [[nodiscard]] double SecondOf(Time at) const {
    std::size_t frame = 0;
    while (frame + 1 < shown_.size() && shown_.time(frame) < at) ++frame;
    return static_cast<double>(frame) / shown_.fps();
  }

 private:
  render::Snapshots shown_;
};

class ResultsWriter {
 public:
  explicit ResultsWriter(const SessionInputs& inputs)
      : inputs_(inputs), session_(report::ReadSession(inputs.out.log())) {}

  void Write() {
    run::WriteWholeFile(inputs_.out.scenario(), scenario::ToYaml(inputs_.scenario));
    run::WriteWholeFile(inputs_.out.summary(), Summary());
    files_.resize(session_.motions.size());
    WritePage();  // an interrupt ends what follows
    LogSplitter(inputs_, session_).Split();
    for (std::size_t i = 0; i < files_.size(); ++i) files_[i] = Explained(i + 1);
    WritePage();
    for (std::size_t i = 0; i < files_.size(); ++i) Plot(i + 1);
    if (inputs_.makes_video && !files_.empty()) MakeVideo();
    WritePage();
  }

 private:
  [[nodiscard]] run::ResultFolder FolderOf(std::size_t number) const {
    return run::ResultFolder(inputs_.out.motion(number));
  }

  MotionFiles Explained(std::size_t number) {
    inputs_.console.ThrowIfInterrupted();
    const report::Explanation explanation = report::Explain(FolderOf(number).log());
    if (explanation.aborted) {
      run::WriteWholeFile(FolderOf(number).explanation(), explanation.page);
    }
    return {.explanation = explanation.text, .has_page = explanation.aborted};
  }

  void Plot(std::size_t number) {
    inputs_.console.ThrowIfInterrupted();
    const run::ResultFolder folder = FolderOf(number);
    files_[number - 1].plots =
        report::WritePlots(folder.log(), inputs_.robot.limits, folder.plots());
    inputs_.console.Show("plots", static_cast<double>(number) / static_cast<double>(files_.size()),
                         fmt::format("motion {} of {}", number, files_.size()));
  }

  void MakeVideo() {
    try {
      const replay::Recording recording(inputs_.out.log(), inputs_.files);
      const SessionFilm part(recording.snapshots());
      render::Film film = recording.Film();
      film.snapshots = &part.shown();
      const render::FilmSettings settings = run::FilmOf(inputs_.scenario.render);
      const MonotonicClock clock;
      replay::RenderClip(render::FramesOf(film, settings),
                         {inputs_.out.video(), inputs_.out.contact_sheet()}, clock,
                         inputs_.console);
      for (std::size_t i = 0; i < files_.size(); ++i) {
        files_[i].film = fmt::format("{:.2f}", part.SecondOf(session_.motions[i].begin));
      }
      has_video_ = true;
    } catch (const Error& error) {
      inputs_.console.ThrowIfInterrupted();  // as in WriteSessionResults()
      inputs_.console.Warn(fmt::format("no video: {}", error.what()));
    }
  }

  [[nodiscard]] std::string Summary() const {
    nlohmann::ordered_json motions = nlohmann::ordered_json::array();
    for (const LoggedMotion& motion : session_.motions) {
      motions.push_back({{"client", motion.client},
                         {"motion_generator", Name(motion.generator)},
                         {"controller", Name(motion.controller)},
                         {"begin_s", SecondsOf(motion.begin)},
                         {"end_s", SecondsOf(motion.end)},
                         {"end", motion.how},
                         {"aborted", motion.is_aborted()},
                         {"cycles_served", motion.served},
                         {"cycles_held", motion.held},
                         {"longest_loss_cycles", motion.longest_loss},
                         {"largest_tracking_error_rad",
                          motion.peak_error ? nlohmann::ordered_json(*motion.peak_error)
                                            : nlohmann::ordered_json()},
                         {"largest_joint_velocity_rad_s", motion.peak_speed}});
    }
    return run::TextOf({{"scenario", inputs_.scenario.name},
                        {"seed", inputs_.scenario.seed},
                        {"drive", inputs_.scenario.drive_name()},
                        {"version", TWIN_VERSION},
                        {"motions", motions}});
  }

  [[nodiscard]] json MotionOnPage(std::size_t number) const {
    const LoggedMotion& motion = session_.motions[number - 1];
    const MotionFiles& files = files_[number - 1];
    json plots = json::array();
    for (const std::filesystem::path& plot : files.plots) {
      plots.push_back({{"file", plot.filename().string()}, {"name", plot.stem().string()}});
    }
    return {{"number", number},
            {"kind", KindOf(motion)},
            {"began", fmt::format("{:.3f}", SecondsOf(motion.begin))},
            {"took", fmt::format("{:.3f}", ToSeconds(motion.end - motion.begin))},
            {"how", motion.how},
            {"verdict", motion.is_aborted() ? "failed" : "met"},
            {"peak_error", motion.peak_error ? fmt::format("{:.2f}", 1e3 * *motion.peak_error)
                                             : std::string("no reference")},
            {"peak_speed", fmt::format("{:.2f}", motion.peak_speed)},
            {"held", motion.held},
            {"longest_loss", motion.longest_loss},
            {"explanation", files.explanation},
            {"has_page", files.has_page},
            {"folder", fmt::format("motions/{}", number)},
            {"film", files.film},
            {"plots", plots}};
  }

  /// Motions in a row of one client stand together.
  [[nodiscard]] json ClientsOnPage() const {
    json clients = json::array();
    for (std::size_t i = 0; i < session_.motions.size(); ++i) {
      const std::string& client = session_.motions[i].client;
      if (i == 0 || client != session_.motions[i - 1].client) {
        clients.push_back({{"client", client}, {"motions", json::array()}});
      }
      clients.back()["motions"].push_back(MotionOnPage(i + 1));
    }
    return clients;
  }

  void WritePage() const {
    const auto aborted = std::ranges::count_if(session_.motions, &LoggedMotion::is_aborted);
    json events = json::array();
    for (const record::EventRecord& event : session_.events) {
      events.push_back({{"at", fmt::format("{:.3f}", SecondsOf(event.at))},
                        {"kind", event.kind},
                        {"text", event.text}});
    }
    const json clients = ClientsOnPage();
    run::WriteWholeFile(inputs_.out.report(),
                        report::RenderPage("application/session",
                                           {{"title", inputs_.scenario.name},
                                            {"count", session_.motions.size()},
                                            {"clients_count", clients.size()},
                                            {"aborted", aborted > 0 ? json(aborted) : json()},
                                            {"video", has_video_},
                                            {"clients", clients},
                                            {"event_count", session_.events.size()},
                                            {"events", events},
                                            {"facts", report::FactsOf(inputs_.facts)}}));
  }

  const SessionInputs& inputs_;
  const LoggedSession session_;
  std::vector<MotionFiles> files_;  ///< one per motion
  bool has_video_ = false;
};

}  // namespace

void WriteSessionResults(const SessionInputs& inputs) {
  try {
    ResultsWriter(inputs).Write();
  } catch (const EnvironmentError&) {
    inputs.console.ThrowIfInterrupted();  // takes precedence over errors that it caused
    throw;
  }
}

}  // namespace twin::application
