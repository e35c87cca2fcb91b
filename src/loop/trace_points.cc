#include "loop/trace_points.h"

// The program has the points, a library of its own what records them (trace_provider.cc): a program
// that is not traced neither needs LTTng nor has its threads.
#define LTTNG_UST_TRACEPOINT_DEFINE
#define LTTNG_UST_TRACEPOINT_PROBE_DYNAMIC_LINKAGE
#include "loop/trace_events.def"

namespace twin::loop {

void TraceReadBegin(std::uint64_t message_id) noexcept {
  lttng_ust_tracepoint(panda_twin, read_begin, message_id);
}

void TraceStateRead(std::uint64_t message_id) noexcept {
  lttng_ust_tracepoint(panda_twin, state_read, message_id);
}

void TraceWriteBegin(std::uint64_t message_id) noexcept {
  lttng_ust_tracepoint(panda_twin, write_begin, message_id);
}

void TraceWriteEnd(std::uint64_t message_id) noexcept {
  lttng_ust_tracepoint(panda_twin, write_end, message_id);
}

}  // namespace twin::loop
