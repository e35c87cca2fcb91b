#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "home_process.h"
#include "twin/application/served_session.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/fci/sockets.h"
#include "twin/model/model_library.h"
#include "twin/rt/child_process.h"
#include "twin/rt/host_time.h"
#include "twin/run/console.h"
#include "twin/run/told_events.h"
#include "twin/server/control_channel.h"
#include "twin/server/control_request.h"
#include "twin/server/controlled_robot.h"

namespace twin::python {
namespace {

/// Seconds since the robot is served, kind and text, as run::EventOf.
using Told = std::tuple<double, std::string, std::string>;

/// Waits without the GIL until `done`; looks for Ctrl-C every 50 ms. @pre the GIL is held.
/// @throws nb::python_error on Ctrl-C.
template <typename Done>
void Await(Done done) {
  constexpr int kLooks = 250;
  constexpr auto kBetween = std::chrono::microseconds(200);
  for (bool is_done = false; !is_done;) {
    {
      const GilReleased release;
      for (int look = 0; look < kLooks && !is_done; ++look) {
        is_done = done();
        if (!is_done) rt::Pause(kBetween);
      }
    }
    if (!is_done && PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

/// Keeps what users must see.
class Notes final : public run::Console {
 public:
  /// While it lives, waits for children end with its interrupt.
  Notes() { rt::GiveUpWhen(&interrupted_); }
  ~Notes() override { rt::GiveUpWhen(nullptr); }
  Notes(const Notes&) = delete;
  Notes& operator=(const Notes&) = delete;

  void Print(std::string_view /*text*/) override {}
  void Say(std::string_view text) override { texts.emplace_back(text); }
  void Debug(std::string_view /*text*/) override {}
  void Note(std::string_view /*text*/) override {}
  void Warn(std::string_view text) override { texts.emplace_back(text); }
  void Show(std::string_view /*work*/, double /*share*/, std::string_view /*note*/) override {}
  [[nodiscard]] const volatile bool& interrupted() const noexcept override { return interrupted_; }
  void Interrupt() noexcept override { interrupted_ = true; }

  std::vector<std::string> texts;

 private:
  volatile bool interrupted_ = false;
};

/// A served robot of this process.
///
/// Threads: any, which hold the GIL.
class Served {
 public:
  /// @param hostname  a loopback address; absent: the first one that is free. @pre without the GIL.
  Served(const application::ServeOptions& options, const std::optional<std::string>& hostname,
         const std::optional<std::filesystem::path>& control) {
    application::ServeHost host;
    host.files = Files();
    host.takes_free_address = !hostname;
    if (hostname) host.server.address = LoopbackOf(*hostname);
    host.server.model_library =
        model::ReadModelLibrary(model::FindModelLibrary(TheHost().executable));
    host.programs = TheHost().path;
    host.tell = [this](std::string_view line) { Keep(line); };
    session_ = std::make_unique<application::ServedSession>(options, std::move(host));
    arm_ = session_->robot().arm();
    drive_ = session_->scenario().drive_name();
    controlled_.emplace(session_->robot(), true);
    if (control) {
      const bool may_reset = session_->reset() != application::ResetPolicy::kNever;
      control_ = std::make_unique<server::ControlChannel>(
          *control, server::ControlledRobot(session_->robot(), may_reset),
          [this](std::string_view line) { session_->Tell(line); });
    }
    session_->StartLog();
    session_->robot().Start();
  }
  ~Served() {
    if (home_.is_elsewhere()) {  // its threads are not here to be joined
      static_cast<void>(control_.release());
      static_cast<void>(session_.release());
    }
    control_.reset();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  /// @param line  as a control channel's. @returns the robot's status, as the channel answers.
  std::string Ask(const std::string& line) {
    server::ControlRequest request;
    {
      const GilReleased release;
      request = server::ParseControlRequest(line);
      WhileOpen([&] {
        controlled_->Do(request);
        if (request.verb == server::ControlVerb::kStatus) return;
        session_->Tell(fmt::format("control: {}", server::ToLine(request)));
      });
    }
    if (server::TakesTime(request.verb)) {
      Await([this] { return !WhileOpen([this] { return controlled_->IsBusy(); }); });
    }
    const GilReleased release;
    return WhileOpen([this] { return controlled_->StatusLine(); });
  }

  /// A second call has no effect, nor one in a fork of the process. @returns what users must see.
  std::vector<std::string> Close() {
    if (home_.is_elsewhere()) return {};
    Notes notes;
    {
      const GilReleased release;
      const std::scoped_lock lock(ending_);
      if (closed_) return {};
      closed_ = true;
      control_.reset();
      session_->End([&notes](std::string_view text) { notes.Warn(text); });
      for (const std::string& loss : session_->NewLosses()) notes.Warn(loss);
    }
    if (session_->out() != nullptr) WriteResults(notes);
    const std::string warnings = session_->robot().DescribeWarnings();
    const GilReleased release;
    session_.reset();
    if (!warnings.empty()) throw RobotFault("the simulation itself became unsound: " + warnings);
    return notes.texts;
  }

  [[nodiscard]] bool is_closed() const noexcept { return closed_; }
  [[nodiscard]] std::string hostname() const { return fci::AddressText(arm_.address); }
  [[nodiscard]] std::uint16_t port() const noexcept { return arm_.port; }
  [[nodiscard]] const std::string& drive() const noexcept { return drive_; }
  [[nodiscard]] std::vector<Told> events() {
    const GilReleased release;
    const std::scoped_lock lock(keeping_);
    return {events_.begin(), events_.end()};
  }

 private:
  static constexpr std::size_t kMostEvents = 100'000;

  static std::uint32_t LoopbackOf(const std::string& hostname) {
    const std::uint32_t address = fci::Resolve(hostname, 0).address;
    if (fci::IsLoopback(address)) return address;
    throw InputError(fmt::format(
        "hostname {} lets other machines move the robot; give one in 127.0.0.0/8, or serve it with "
        "panda-twin serve --bind {} --allow ADDRESS/BITS",
        hostname, hostname));
  }

  /// @throws InputError once it is closed. @pre without the GIL.
  template <typename Action>
  std::invoke_result_t<Action> WhileOpen(Action action) {
    home_.Require("a served robot");
    const std::shared_lock lock(ending_);
    if (closed_) throw InputError("this robot is closed; serve another one");
    return action();
  }

  void Keep(std::string_view line) {
    const run::ToldEvent event = run::EventOf(line);
    const std::scoped_lock lock(keeping_);
    if (events_.size() == kMostEvents) events_.pop_front();
    events_.emplace_back(ToSeconds(clock_.Now().time_since_epoch()), event.kind, event.text);
  }

  /// On a thread of its own, so that Ctrl-C is seen.
  void WriteResults(Notes& notes) {
    std::exception_ptr failure;
    std::atomic<bool> is_done = false;  // what was written before it is read after it: seq_cst
    std::jthread writer([&] {
      try {
        session_->WriteResults(notes);
      } catch (...) {
        failure = std::current_exception();
      }
      is_done = true;
    });
    try {
      Await([&] { return is_done.load(); });
    } catch (...) {
      notes.Interrupt();
      const GilReleased release;
      writer.join();
      throw;
    }
    writer.join();
    if (failure) std::rethrow_exception(failure);
  }

  const HomeProcess home_;
  const MonotonicClock clock_;
  std::mutex keeping_;
  std::deque<Told> events_;  ///< guarded by keeping_
  std::shared_mutex ending_;
  std::atomic<bool> closed_ = false;  ///< set under ending_
  std::unique_ptr<application::ServedSession> session_;
  fci::Endpoint arm_;
  std::string drive_;
  std::optional<server::ControlledRobot> controlled_;
  std::unique_ptr<server::ControlChannel> control_;
};

}  // namespace

void AddServed(nb::module_& module) {
  using application::ServeOptions;
  nb::class_<ServeOptions>(module, "ServeOptions")
      .def(nb::init<>())
      .def_rw("scenario", &ServeOptions::scenario)
      .def_rw("yaml", &ServeOptions::yaml)
      .def_rw("lab", &ServeOptions::lab, nb::arg().none())
      .def_rw("model", &ServeOptions::model, nb::arg().none())
      .def_rw("scene", &ServeOptions::scene, nb::arg().none())
      .def_rw("seed", &ServeOptions::seed, nb::arg().none())
      .def_rw("drive", &ServeOptions::drive, nb::arg().none())
      .def_rw("pace", &ServeOptions::pace, nb::arg().none())
      .def_rw("idle", &ServeOptions::idle)
      .def_rw("clock_ppm", &ServeOptions::clock_ppm, nb::arg().none())
      .def_rw("session_timeout", &ServeOptions::session_timeout)
      .def_rw("viability", &ServeOptions::viability, nb::arg().none())
      .def_rw("guard", &ServeOptions::guard)
      .def_rw("reset", &ServeOptions::reset)
      .def_rw("out", &ServeOptions::out, nb::arg().none())
      .def_rw("no_video", &ServeOptions::no_video)
      .def_rw("log", &ServeOptions::log, nb::arg().none())
      .def_rw("log_split", &ServeOptions::log_split, nb::arg().none())
      .def_rw("log_keep", &ServeOptions::log_keep, nb::arg().none())
      .def_rw("capture", &ServeOptions::capture, nb::arg().none());
  nb::class_<Served>(module, "Served")
      .def("ask", &Served::Ask)
      .def("close", &Served::Close)
      .def_prop_ro("closed", &Served::is_closed)
      .def_prop_ro("hostname", &Served::hostname)
      .def_prop_ro("port", &Served::port)
      .def_prop_ro("drive", &Served::drive)
      .def_prop_ro("events", &Served::events);
  module.def(
      "serve",
      [](const ServeOptions& options, const std::optional<std::string>& hostname,
         const std::optional<std::filesystem::path>& control) {
        const GilReleased release;
        return std::make_unique<Served>(options, hostname, control);
      },
      nb::arg("options"), nb::arg("hostname").none(), nb::arg("control").none());
}

}  // namespace twin::python
