#pragma once

#include <cstdint>

#include "twin/core/realtime.h"

/// LTTng's tracepoints around a state's read and its command's write, as the paper measured d_EXT.
///
/// Only in builds with -DTWIN_LTTNG=ON; other builds contain no tracepoint. trace_events.def lists
/// the events and their meaning. They reach a trace when the program runs under scripts/trace,
/// which loads the recording library (trace_provider.cc) into the program.
///
/// Threads: any. Real-time: a load and a branch while LTTng does not record. While it records, a
/// thread's first event registers the thread with LTTng, which locks a mutex; the communication
/// thread has its first event before a motion begins, at the read of the first state. Later events
/// do not lock, allocate or make a system call: with scripts/trace, a timer of the reader fetches
/// them.
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
