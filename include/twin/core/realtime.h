#pragma once

/// Marks a function that the 1 kHz path may call: no allocation, no lock that waits, no I/O, no
/// log, no throw. Compilers that can prove it (LLVM 20 and later) are asked to; elsewhere the guard
/// in tests/support checks it at run time.
#if defined(__clang__) && __clang_major__ >= 20
#define TWIN_REALTIME [[clang::nonblocking]]
#else
#define TWIN_REALTIME
#endif
