#include "twin/rt/pause.h"

#include <thread>

namespace twin::rt {

void Pause(Duration duration) {
  std::this_thread::sleep_for(duration);
}

}  // namespace twin::rt
