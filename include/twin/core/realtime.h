#pragma once

/// Marks a function that the 1 kHz path may call: no allocation, no blocking lock, no I/O, no log,
/// no throw. LLVM 20 and later verify it at compile time; elsewhere the guard in tests/support
/// checks it at run time.
#if defined(__clang__) && __clang_major__ >= 20
#define TWIN_REALTIME [[clang::nonblocking]]
#else
#define TWIN_REALTIME
#endif
