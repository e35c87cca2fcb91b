#include "plugins/devices/lockstep_refusal.h"

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::devices {

void RefuseLockstep(const teleop::DeviceRequest& request, std::string_view device) {
  if (!request.is_lockstep) return;
  throw InputError(
      fmt::format("device \"{}\" goes with --drive realtime: in lockstep time is virtual, and no "
                  "hand keeps up with it; what was recorded runs there, as device \"script\"",
                  device));
}

}  // namespace twin::devices
