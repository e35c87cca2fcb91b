#include <unistd.h>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "plugins/devices/event_source.h"
#include "twin/core/clock.h"
#include "twin/core/error.h"
#include "twin/rt/host_time.h"

namespace twin::cli {
namespace {

struct DevicesFlags {
  std::string device;                 ///< which to show; empty: only list them
  std::vector<std::string> settings;  ///< its parameters, KEY=VALUE
  double seconds = 10;                ///< how long it is shown
  std::optional<std::string> record;  ///< file its samples go into
};

constexpr Duration kBetweenReads = std::chrono::milliseconds(5);
constexpr Duration kBetweenLines = std::chrono::milliseconds(100);

std::string LineOf(const devices::FoundDevice& device) {
  const devices::EvdevCapabilities& has = device.capabilities;
  const auto kind = devices::KindOf(has);
  std::string_view text = "none to lead with";
  if (kind == devices::EvdevKind::kSpaceMouse) text = "SpaceMouse";
  if (kind == devices::EvdevKind::kGamepad) text = has.can_rumble ? "gamepad, rumbles" : "gamepad";
  return fmt::format("  {:<20}{:<20}{} ({} axes, {} buttons)\n", device.path.string(), text,
                     has.name, has.abs.size() + has.rel.size(), has.keys.size());
}

void ListDevices(const teleop::DeviceRegistry& devices) {
  std::string text = "input devices:\n";
  const auto found = devices::FindEventDevices();
  std::size_t closed = 0;
  std::string why_not;
  for (const devices::FoundDevice& device : found) {
    if (device.why_not.empty()) {
      text += LineOf(device);
    } else if (closed++ == 0) {
      why_not = device.why_not;
    }
  }
  // Keyboards are readable for their group only: one line for all.
  if (closed > 0) text += fmt::format("  {} cannot be opened; {}\n", closed, why_not);
  if (found.empty()) text += "  none: nothing is plugged in, or this machine shows no /dev/input\n";
  text += fmt::format("devices of scenarios: {}; panda-twin devices NAME shows one\n",
                      fmt::join(devices.Names(), ", "));
  Say(stdout, text);
}

/// What of the command line a factory gets.
control::Parameters ParametersOf(const DevicesFlags& flags) {
  control::Parameters parameters;
  const auto add = [&](std::string key, std::string value) {
    if (std::ranges::find(parameters, key, &control::Parameter::key) != parameters.end()) {
      throw InputError(fmt::format("--set {}: is given twice", key));
    }
    parameters.push_back({.key = std::move(key), .values = {std::move(value)}});
  };
  for (const std::string& setting : flags.settings) {
    const std::size_t sign = setting.find('=');
    if (sign == 0 || sign == std::string::npos) {
      throw InputError(fmt::format("--set \"{}\": write KEY=VALUE, such as port=4811", setting));
    }
    add(setting.substr(0, sign), setting.substr(sign + 1));
  }
  if (flags.record) add("record", *flags.record);
  return parameters;
}

/// The device that is meant: one of the registry, or an input device by its path or name.
std::unique_ptr<teleop::Device> Make(const DevicesFlags& flags,
                                     const teleop::DeviceRegistry& devices,
                                     const MonotonicClock& clock) {
  control::Parameters parameters = ParametersOf(flags);
  std::string name = flags.device;
  const std::vector<std::string> names = devices.Names();
  if (std::ranges::find(names, name) == names.end()) {
    parameters.push_back({.key = name.starts_with('/') ? "path" : "name", .values = {name}});
    name = "evdev";
  }
  control::ParameterReader reader(parameters, "--set");
  auto device = devices.Find(name)({.parameters = reader, .folder = {}, .clock = clock});
  reader.RefuseUnread();
  return device;
}

/// Short enough for a terminal's line: buttons are left out until they are pressed.
std::string LineOf(const teleop::OperatorSample& sample) {
  const Vector6& a = sample.axes;
  std::string line =
      fmt::format("x {:+.2f} y {:+.2f} z {:+.2f} rx {:+.2f} ry {:+.2f} rz {:+.2f}{}", a[0], a[1],
                  a[2], a[3], a[4], a[5], sample.engaged ? "" : " clutch");
  const std::pair<std::string_view, std::uint32_t> buttons[] = {
      {"mode", sample.mode_presses},   {"gripper", sample.gripper_presses},
      {"frame", sample.frame_presses}, {"scale", sample.scale_presses},
      {"stop", sample.stop_presses},   {"release", sample.release_presses},
      {"end", sample.end_presses}};
  for (const auto& [name, presses] : buttons) {
    if (presses > 0) line += fmt::format(" {} {}", name, presses);
  }
  return line;
}

/// Shows samples as they come.
class Show {
 public:
  explicit Show(teleop::Device& device) : device_(device) {}

  /// Reads once, and shows what came.
  void Read(Time now) {
    const auto sample = device_.Read(now);
    if (sample) {
      if (samples_ > 0) longest_pause_ = std::max(longest_pause_, now - came_);
      came_ = now;
      // Nothing is felt; a device's own program sees that it is heard.
      device_.Feel({.sequence = ++samples_, .echo = sample->sequence});
    }
    if (device_.lost() != is_lost_) {
      is_lost_ = !is_lost_;
      Line(is_lost_ ? "lost" : "found again");
      End();
    }
    if (!sample || now < due_) return;
    due_ = now + kBetweenLines;
    Line(LineOf(*sample));
  }

  /// @returns whether any sample came.
  bool Sum() {
    End();
    Say(stdout, samples_ == 0 ? std::string("no sample came\n")
                              : fmt::format("{} samples, the longest pause between two {:.0f} ms\n",
                                            samples_, 1e3 * ToSeconds(longest_pause_)));
    return samples_ > 0;
  }

 private:
  void Line(const std::string& text) {
    // \r and "erase to the end of the line" redraw it in place.
    Say(stdout, is_terminal_ ? fmt::format("\r{}\x1b[K", text) : text + "\n");
    std::fflush(stdout);
    is_open_ = is_terminal_;
  }
  void End() {
    if (std::exchange(is_open_, false)) Say(stdout, "\n");
  }

  teleop::Device& device_;
  const bool is_terminal_ = isatty(STDOUT_FILENO) != 0;
  bool is_open_ = false;  ///< the terminal's line is
  bool is_lost_ = false;
  std::uint64_t samples_ = 0;
  Duration longest_pause_{};
  Time came_{};  ///< when the newest did
  Time due_{};   ///< when a line may be printed again
};

int ShowDevices(const DevicesFlags& flags, const Program& program) {
  RequireInRange("--for (s)", flags.seconds, 0.1, 3600);
  if (flags.device.empty()) {
    ListDevices(*program.catalogue.devices);
    FinishOutput();
    return kOk;
  }
  const InterruptGuard interrupt;
  const MonotonicClock clock;
  const std::unique_ptr<teleop::Device> device = Make(flags, *program.catalogue.devices, clock);
  Say(stdout, device->Describe() + "\n");
  std::fflush(stdout);
  Show show(*device);
  const Time begun = clock.Now();
  const Time end = begun + FromSeconds(flags.seconds);
  for (Time next = begun; next < end && !interrupt.interrupted(); next += kBetweenReads) {
    rt::SleepUntil(clock, next);
    show.Read(clock.Now());
  }
  const bool has_come = show.Sum();
  FinishOutput();
  if (interrupt.interrupted()) return kInterrupted;
  return has_come ? kOk : kFailed;
}

}  // namespace

void AddDevices(CLI::App& app, Program& program) {
  const auto [devices, flags] = AddCommand(
      app, program, "devices", "List what an operator can lead with, or show what one device tells",
      &ShowDevices);
  CLI::Option* device = Add(devices, "device DEVICE", flags.device, "Which to show");
  Add(devices, "--for S", flags.seconds, "Show it for so long (0.1 to 3600)")
      ->capture_default_str()
      ->needs(device);
  Add(devices, "--set KEY=VALUE", flags.settings, "A parameter of the device; may be repeated")
      ->allow_extra_args(false)
      ->needs(device);
  Add(devices, "--record FILE", flags.record, "Keep its samples, as a script (CSV)")->needs(device);
}

}  // namespace twin::cli
