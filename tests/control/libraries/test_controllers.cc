// One source for all libraries of the loader's tests; a macro says which it is.

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "twin/control/controller_library.h"
#include "twin/core/error.h"

namespace {

using twin::control::ControllerOutput;
using twin::control::ControllerRequest;

/// Follows the trajectory's positions with an offset of its own, one parameter.
class Follower : public twin::control::Controller {
 public:
  explicit Follower(const ControllerRequest& request) : trajectory_(request.trajectory) {}

  [[nodiscard]] twin::control::CommandInterface command_interface() const noexcept override {
    return twin::control::CommandInterface::kJointPosition;
  }
  void Configure(twin::control::ParameterReader& parameters) override {
    patience_ =
        parameters.Time("patience", patience_, twin::Duration::zero(), twin::kCycle * 60000);
  }
  void Activate(const twin::RobotState& /*state*/, twin::Time /*now*/) override {
    running_ = false;
  }
  void Update(const twin::RobotState& /*state*/, twin::Time now,
              ControllerOutput& output) noexcept override {
    if (!running_) start_ = now;
    running_ = true;
    output.target.joint = trajectory_.Sample(now - start_);
    output.finished = now - start_ >= trajectory_.duration();
    output.failed = patience_ > twin::Duration::zero() && now - start_ >= patience_;
  }
  void Deactivate() noexcept override {}
  [[nodiscard]] std::string Explain() const override {
    return patience_ > twin::Duration::zero() ? "the follower lost its patience" : "";
  }

 private:
  const twin::reference::Trajectory& trajectory_;
  twin::Duration patience_{};
  twin::Time start_{};
  bool running_ = false;
};

#if defined(TWIN_TEST_GOOD)

struct ThrowsInConstructor : Follower {
  explicit ThrowsInConstructor(const ControllerRequest& request) : Follower(request) {
    throw std::runtime_error("no such luck");
  }
};

struct ThrowsNumber : Follower {
  explicit ThrowsNumber(const ControllerRequest& request) : Follower(request) { throw 42; }
};

struct ThrowsInConfigure : Follower {
  using Follower::Follower;
  void Configure(twin::control::ParameterReader& /*parameters*/) override {
    throw std::out_of_range("index 8");
  }
};

struct ThrowsInActivate : Follower {
  using Follower::Follower;
  void Activate(const twin::RobotState& /*state*/, twin::Time /*now*/) override { throw 42; }
};

struct Refuses : Follower {
  using Follower::Follower;
  void Activate(const twin::RobotState& /*state*/, twin::Time /*now*/) override {
    throw twin::InputError("not from here; go home first");
  }
};

twin::control::Controller* MakeNull(const ControllerRequest& /*request*/,
                                    twin::control::MakeFailure& /*failure*/) {
  return nullptr;
}

twin::control::Controller* Throw(const ControllerRequest& /*request*/,
                                 twin::control::MakeFailure& /*failure*/) {
  throw std::runtime_error("thrown past the border");
}

}  // namespace

TWIN_CONTROLLERS({"follower", &twin::control::MakeController<Follower>},
                 {"throws", &twin::control::MakeController<ThrowsInConstructor>},
                 {"throws_number", &twin::control::MakeController<ThrowsNumber>},
                 {"throws_in_configure", &twin::control::MakeController<ThrowsInConfigure>},
                 {"throws_in_activate", &twin::control::MakeController<ThrowsInActivate>},
                 {"refuses", &twin::control::MakeController<Refuses>}, {"null", &MakeNull},
                 {"throws_past_the_border", &Throw});

#else

const twin::control::ControllerEntry controllers[] = {
    {"follower", &twin::control::MakeController<Follower>}};

[[maybe_unused]] const twin::control::ControllerLibraryInfo* Info(std::uint32_t abi,
                                                                  std::uint64_t layout) {
  static twin::control::ControllerLibraryInfo info;
  info = {.abi = abi, .count = 1, .layout = layout, .controllers = controllers};
  return &info;
}

}  // namespace

#ifdef TWIN_TEST_RUNS_WHEN_LOADED
/// Code that runs as soon as the library is loaded, and tells so by the exit code.
[[maybe_unused]] const struct AtLoad {
  AtLoad() noexcept { std::_Exit(77); }
} at_load;
#endif

#ifdef TWIN_TEST_UNRESOLVED
extern "C" int this_function_is_nowhere();
#endif

#ifndef TWIN_TEST_NO_ENTRY
extern "C" __attribute__((visibility("default"))) const twin::control::ControllerLibraryInfo*
panda_twin_controllers() {
#if defined(TWIN_TEST_OTHER_VERSION)
  return Info(999, twin::control::kControllerLayout);
#elif defined(TWIN_TEST_OTHER_HEADERS)
  return Info(twin::control::kControllerLibraryAbi, 1);
#elif defined(TWIN_TEST_NULL_ENTRY)
  return nullptr;
#elif defined(TWIN_TEST_THROWING_ENTRY)
  throw std::runtime_error("the entry is closed");
#elif defined(TWIN_TEST_UNRESOLVED)
  return this_function_is_nowhere() == 0 ? nullptr : Info(1, 1);
#elif defined(TWIN_TEST_RUNS_WHEN_LOADED)
  return Info(twin::control::kControllerLibraryAbi, twin::control::kControllerLayout);
#endif
}
#endif

#endif
