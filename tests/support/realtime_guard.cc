#include "support/realtime_guard.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TWIN_TEST_SANITIZED 1
#else
#define TWIN_TEST_SANITIZED 0
#endif

namespace twin::test {
namespace {

// Zero-initialised and in the program's own image, so that counting itself never allocates.
constinit thread_local RealtimeGuard::Counts thread_counts;

void CountAllocation() noexcept {
  ++thread_counts.allocations;
}

void CountFree(const volatile void* memory) noexcept {
  if (memory != nullptr) ++thread_counts.frees;
}

}  // namespace

RealtimeGuard::RealtimeGuard() noexcept : start_(thread_counts) {}

RealtimeGuard::Counts RealtimeGuard::counts() const noexcept {
  return {.allocations = thread_counts.allocations - start_.allocations,
          .frees = thread_counts.frees - start_.frees,
          .locks = thread_counts.locks - start_.locks};
}

}  // namespace twin::test

#if TWIN_TEST_SANITIZED

// The sanitizers own malloc; they offer hooks instead. Declared here: g++ comes without their
// headers.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*,
                                                                           std::size_t),
                                                         void (*on_free)(const volatile void*));

namespace {

[[maybe_unused]] const int kHooksInstalled = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { twin::test::CountAllocation(); },
    [](const volatile void* memory) { twin::test::CountFree(memory); });

}  // namespace

#else

// The program's own malloc comes first in symbol look-up, for every library of the process; glibc's
// is reached by its second name.
extern "C" {

void* LibcMalloc(std::size_t size) __asm__("__libc_malloc");
void* LibcCalloc(std::size_t count, std::size_t size) __asm__("__libc_calloc");
void* LibcRealloc(void* memory, std::size_t size) __asm__("__libc_realloc");
void* LibcMemalign(std::size_t alignment, std::size_t size) __asm__("__libc_memalign");
void LibcFree(void* memory) __asm__("__libc_free");

void* malloc(std::size_t size) {
  twin::test::CountAllocation();
  return LibcMalloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  twin::test::CountAllocation();
  return LibcCalloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
  twin::test::CountAllocation();
  return LibcRealloc(memory, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  twin::test::CountAllocation();
  return LibcMemalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  twin::test::CountAllocation();
  return LibcMemalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  twin::test::CountAllocation();
  void* result = LibcMemalign(alignment, size);
  if (result == nullptr) return ENOMEM;
  *memory = result;
  return 0;
}

void free(void* memory) {
  twin::test::CountFree(memory);
  LibcFree(memory);
}

}  // extern "C"

#endif

namespace {

/// The next definition of `name` behind ours: glibc's, or the sanitizer's.
template <typename Function>
Function NextDefinition(std::atomic<Function>& known, const char* name) noexcept {
  Function function = known.load(std::memory_order_relaxed);  // the same value from every thread
  if (function == nullptr) {
    function = reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
    known.store(function, std::memory_order_relaxed);
  }
  return function;
}

using MutexLock = int (*)(pthread_mutex_t*);
using RwLock = int (*)(pthread_rwlock_t*);
constinit std::atomic<MutexLock> next_mutex_lock{nullptr};
constinit std::atomic<RwLock> next_read_lock{nullptr};
constinit std::atomic<RwLock> next_write_lock{nullptr};

// Looked up before any guard lives: a look-up may itself give memory back. Locks taken still
// earlier, while libraries start, look up for themselves.
[[maybe_unused]] const bool kLookedUp = NextDefinition(next_mutex_lock, "pthread_mutex_lock") &&
                                        NextDefinition(next_read_lock, "pthread_rwlock_rdlock") &&
                                        NextDefinition(next_write_lock, "pthread_rwlock_wrlock");

}  // namespace

// Not instrumented: these run before a sanitizer has started, and stand between it and its own
// interceptors.
#define TWIN_TEST_RAW __attribute__((no_sanitize("thread", "address")))

extern "C" {

TWIN_TEST_RAW int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  ++twin::test::thread_counts.locks;
  return NextDefinition(next_mutex_lock, "pthread_mutex_lock")(mutex);
}

TWIN_TEST_RAW int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  ++twin::test::thread_counts.locks;
  return NextDefinition(next_read_lock, "pthread_rwlock_rdlock")(lock);
}

TWIN_TEST_RAW int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  ++twin::test::thread_counts.locks;
  return NextDefinition(next_write_lock, "pthread_rwlock_wrlock")(lock);
}

}  // extern "C"
