#include "loop/trace_points.h"

// The program contains the tracepoints; a separate library records them (trace_provider.cc). An
// untraced program therefore neither needs LTTng nor runs its threads.
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
