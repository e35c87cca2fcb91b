#include "plugins/devices/evdev_profile.h"

#include <libevdev/libevdev.h>
#include <linux/input.h>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace twin::devices {
namespace {

using teleop::OperatorSample;

constexpr std::array<std::string_view, 6> kAxisNames{"x", "y", "z", "rx", "ry", "rz"};

/// A button's function, except the clutch.
struct ButtonUse {
  std::string_view name;
  std::uint32_t OperatorSample::*presses;
  std::uint16_t on_gamepad;  ///< code of the default key
};
constexpr std::array<ButtonUse, 7> kButtonUses{
    {{"mode", &OperatorSample::mode_presses, BTN_Y},
     {"gripper", &OperatorSample::gripper_presses, BTN_A},
     {"frame", &OperatorSample::frame_presses, BTN_X},
     {"scale", &OperatorSample::scale_presses, BTN_TR},
     {"stop", &OperatorSample::stop_presses, BTN_B},
     {"release", &OperatorSample::release_presses, BTN_START},
     {"end", &OperatorSample::end_presses, BTN_SELECT}}};
constexpr std::uint16_t kClutchOnGamepad = BTN_TL;

AxisSource Absolute(const EvdevCapabilities& capabilities, std::uint16_t code, double sign) {
  if (!capabilities.abs.contains(code)) return {};
  return {AxisSource::Kind::kAbsolute, code, sign};
}

/// A SpaceMouse's axis: older kernels call it relative, though it reports positions.
AxisSource Either(const EvdevCapabilities& capabilities, std::uint16_t abs, std::uint16_t rel) {
  if (capabilities.abs.contains(abs)) return {AxisSource::Kind::kAbsolute, abs, -1};
  return {AxisSource::Kind::kRelative, rel, -1};
}

EvdevProfile SpaceMouseProfile(const EvdevCapabilities& has) {
  EvdevProfile profile;
  profile.axes = {Either(has, ABS_Y, REL_Y),   Either(has, ABS_X, REL_X),
                  Either(has, ABS_Z, REL_Z),   Either(has, ABS_RY, REL_RY),
                  Either(has, ABS_RX, REL_RX), Either(has, ABS_RZ, REL_RZ)};
  if (has.keys.contains(BTN_0) && has.keys.contains(BTN_1)) {
    profile.two_buttons = {BTN_0, BTN_1};
  }
  return profile;
}

EvdevProfile GamepadProfile(const EvdevCapabilities& has) {
  EvdevProfile profile;
  profile.axes = {Absolute(has, ABS_Y, -1),     Absolute(has, ABS_X, -1),
                  Absolute(has, ABS_RY, -1),    Absolute(has, ABS_HAT0X, 1),
                  Absolute(has, ABS_HAT0Y, -1), Absolute(has, ABS_RX, -1)};
  for (const ButtonUse& use : kButtonUses) {
    if (has.keys.contains(use.on_gamepad)) profile.keys.push_back({use.on_gamepad, use.presses});
  }
  if (has.keys.contains(kClutchOnGamepad)) profile.clutch = kClutchOnGamepad;
  return profile;
}

std::optional<std::uint16_t> CodeOf(unsigned type, const std::string& name) {
  const int code = libevdev_event_code_from_name(type, name.c_str());
  if (code < 0) return {};
  return static_cast<std::uint16_t>(code);
}

AxisSource AxisFromParameter(const control::ParameterReader& parameters, const std::string& key,
                             const std::string& text, const EvdevCapabilities& has) {
  if (text == "none") return {};
  const bool is_negative = text.starts_with('-');
  const std::string name = text.substr(is_negative ? 1 : 0);
  const double sign = is_negative ? -1 : 1;
  if (const auto code = CodeOf(EV_ABS, name)) {
    if (has.abs.contains(*code)) return {AxisSource::Kind::kAbsolute, *code, sign};
  } else if (const auto relative = CodeOf(EV_REL, name)) {
    if (has.rel.contains(*relative)) return {AxisSource::Kind::kRelative, *relative, sign};
  } else {
    parameters.Refuse(key, "is no axis; write one like ABS_RX, REL_Y or -ABS_Z, or none");
  }
  parameters.Refuse(
      key, fmt::format("\"{}\" has no such axis; panda-twin devices shows what it has", has.name));
}

std::optional<std::uint16_t> KeyFromParameter(const control::ParameterReader& parameters,
                                              const std::string& key, const std::string& text,
                                              const EvdevCapabilities& has) {
  if (text == "none") return {};
  const auto code = CodeOf(EV_KEY, text);
  if (!code) parameters.Refuse(key, "is no key; write one like BTN_SOUTH or BTN_0, or none");
  if (has.keys.contains(*code)) return code;
  parameters.Refuse(key, fmt::format("\"{}\" has no such key", has.name));
}

}  // namespace

std::optional<EvdevKind> KindOf(const EvdevCapabilities& capabilities) {
  const auto has_all = [](const auto& codes, std::initializer_list<std::uint16_t> wanted) {
    return std::ranges::all_of(wanted, [&](std::uint16_t code) { return codes.contains(code); });
  };
  if (capabilities.keys.contains(BTN_GAMEPAD) && has_all(capabilities.abs, {ABS_X, ABS_Y})) {
    return EvdevKind::kGamepad;
  }
  const bool is_absolute = has_all(capabilities.abs, {ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ});
  const bool is_relative = has_all(capabilities.rel, {REL_X, REL_Y, REL_Z, REL_RX, REL_RY, REL_RZ});
  if (is_absolute || is_relative) return EvdevKind::kSpaceMouse;
  return {};
}

EvdevProfile UsualProfile(EvdevKind kind, const EvdevCapabilities& capabilities) {
  return kind == EvdevKind::kSpaceMouse ? SpaceMouseProfile(capabilities)
                                        : GamepadProfile(capabilities);
}

void ApplyParameters(control::ParameterReader& parameters, const EvdevCapabilities& capabilities,
                     EvdevProfile& profile) {
  for (std::size_t i = 0; i < kAxisNames.size(); ++i) {
    const std::string key = fmt::format("axes.{}", kAxisNames[i]);
    const std::string text = parameters.Text(key, "");
    if (!text.empty()) profile.axes[i] = AxisFromParameter(parameters, key, text, capabilities);
  }
  for (const ButtonUse& use : kButtonUses) {
    const std::string key = fmt::format("buttons.{}", use.name);
    const std::string text = parameters.Text(key, "");
    if (text.empty()) continue;
    profile.two_buttons.reset();
    std::erase_if(profile.keys, [&](const auto& one) { return one.presses == use.presses; });
    const auto code = KeyFromParameter(parameters, key, text, capabilities);
    if (code) profile.keys.push_back({*code, use.presses});
  }
  const std::string clutch = parameters.Text("buttons.clutch", "");
  if (clutch.empty()) return;
  profile.two_buttons.reset();
  profile.clutch = KeyFromParameter(parameters, "buttons.clutch", clutch, capabilities);
}

}  // namespace twin::devices
