#pragma once

#include <cstdint>

#include "twin/core/realtime.h"

/// LTTng's tracepoints around a state's read and its command's write, as the paper measured d_EXT.
///
/// Only in builds with -DTWIN_LTTNG=ON; in others nothing is left of them. The events, and what
/// each means, are in trace_events.def. They reach a trace when the program runs under
/// scripts/trace, which loads what records them (trace_provider.cc) into the program.
///
/// Threads: any. Real-time: a load and a branch as long as nobody records. While LTTng records, a
/// thread's first event registers the thread with LTTng, which locks a mutex;
/// the communication has its first event before a motion begins, when it looks for the first state.
/// Later events neither lock nor allocate, and make no system call: scripts/trace lets a timer of
/// the reader's fetch them.
namespace twin::loop {

#ifdef TWIN_LTTNG

void TraceReadBegin(std::uint64_t message_id) noexcept TWIN_REALTIME;
void TraceStateRead(std::uint64_t message_id) noexcept TWIN_REALTIME;
void TraceWriteBegin(std::uint64_t message_id) noexcept TWIN_REALTIME;
void TraceWriteEnd(std::uint64_t message_id) noexcept TWIN_REALTIME;

#else

inline void TraceReadBegin(std::uint64_t /*message_id*/) noexcept TWIN_REALTIME {}
inline void TraceStateRead(std::uint64_t /*message_id*/) noexcept TWIN_REALTIME {}
inline void TraceWriteBegin(std::uint64_t /*message_id*/) noexcept TWIN_REALTIME {}
inline void TraceWriteEnd(std::uint64_t /*message_id*/) noexcept TWIN_REALTIME {}

#endif

}  // namespace twin::loop
