#include "cli/devices_options.h"

namespace twin::cli {
namespace {

constexpr const char* kFooter =
    R"(DEVICE is evdev, network or script, as scenarios name them; the path of an input device; or part of its name:
  panda-twin devices                                      what is plugged in
  panda-twin devices spacemouse                           its axes and buttons, live
  panda-twin devices /dev/input/event5 --record me.csv    the same, into a script
  panda-twin devices network --set token=secret           a device's own program, over UDP
  panda-twin devices script --set file=me.csv             what was recorded
Parameters and buttons: plugins/devices/README.md. Axes are ahead, left, up, and about them; of buttons it tells how
often each was pressed, once it was. Nothing moves.
Exit codes: 0 ok, 1 no sample came, 130 when interrupted, others as ever.)";

}  // namespace

CLI::App* AddDevices(CLI::App& app, DevicesFlags& flags) {
  CLI::App* devices = app.add_subcommand(
      "devices", "List what an operator can lead with, or show what one device tells");
  CLI::Option* device = devices->add_option("device", flags.device, "Which to show");
  device->type_name("DEVICE");
  devices->add_option("--for", flags.seconds, "Show it for so long (0.1 to 3600)")
      ->capture_default_str()
      ->type_name("S")
      ->needs(device);
  devices->add_option("--set", flags.settings, "A parameter of the device; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->needs(device);
  devices->add_option("--record", flags.record, "Keep its samples, as a script (CSV)")
      ->type_name("FILE")
      ->needs(device);
  devices->footer(kFooter);
  return devices;
}

}  // namespace twin::cli
