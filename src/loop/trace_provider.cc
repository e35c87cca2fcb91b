// libpanda_twin_tracepoints.so: records the events of trace_events.def. scripts/trace loads it into
// a program with tracepoints.
#define LTTNG_UST_TRACEPOINT_CREATE_PROBES
#include "loop/trace_events.def"
