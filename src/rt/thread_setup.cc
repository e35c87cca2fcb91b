#include "twin/rt/thread_setup.h"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <future>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::rt {
namespace {

constexpr std::size_t kLongestName = 15;  // kernel limit, without the closing zero
constexpr std::size_t kPage = 4096;

void RequireSound(const ThreadSettings& settings) {
  TWIN_CHECK(settings.name.size() <= kLongestName);
  TWIN_CHECK(settings.nice >= 0 && settings.nice <= 19);
  const int most = sched_get_priority_max(SCHED_FIFO);
  if (settings.fifo_priority < 0 || settings.fifo_priority > most) {
    throw InputError(fmt::format(
        "thread \"{}\": FIFO priority is {}; it must lie in [1, {}], or be 0 for the ordinary "
        "scheduler",
        settings.name, settings.fifo_priority, most));
  }
  const long processors = std::min<long>(sysconf(_SC_NPROCESSORS_CONF), CPU_SETSIZE);
  if (settings.cpu && (*settings.cpu < 0 || *settings.cpu >= processors)) {
    throw InputError(
        fmt::format("thread \"{}\": processor is {}; this machine has 0 to {}: leave it out to run "
                    "on any",
                    settings.name, *settings.cpu, processors - 1));
  }
}

/// Whether this process may lock unlimited memory. With a limit, locking all future pages succeeds
/// now, but allocations fail once the limit is reached.
bool MayLockAllMemory() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &header, &data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

/// Touches `pages` pages of stack below the caller's frame, which the caller knows to exist.
__attribute__((noinline)) void TouchStack(std::size_t pages) {
  auto* const lowest = static_cast<volatile char*>(__builtin_alloca(pages * kPage));
  for (std::size_t page = pages; page > 0; --page) lowest[(page - 1) * kPage] = 0;
}

/// Pages of stack that certainly exist below this frame, less a quarter for the thread's use.
std::size_t StackPagesLeft() {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return 0;
  void* lowest = nullptr;
  std::size_t size = 0;
  const bool known = pthread_attr_getstack(&attributes, &lowest, &size) == 0;
  pthread_attr_destroy(&attributes);
  const auto here = reinterpret_cast<std::uintptr_t>(&attributes);
  const auto end = reinterpret_cast<std::uintptr_t>(lowest);
  return known && here > end ? (here - end) / 4 * 3 / kPage : 0;
}

bool LockMemory() {
  return MayLockAllMemory() && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

bool BindTo(int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  return pthread_setaffinity_np(pthread_self(), sizeof(cpus), &cpus) == 0;
}

bool UseFifo(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace

std::vector<std::string> SetUpThisThread(const ThreadSettings& settings) {
  RequireSound(settings);
  std::vector<std::string> notices;
  if (!settings.name.empty()) pthread_setname_np(pthread_self(), settings.name.c_str());
  if (settings.lock_memory && !LockMemory()) {
    notices.emplace_back(
        "memory is not locked: a page that has to be fetched can cost a cycle; add \"@realtime - "
        "memlock unlimited\" to /etc/security/limits.conf, join the group realtime, log in again");
  }
  const std::size_t wanted = settings.stack_kb * 1024 / kPage;
  if (const std::size_t pages = std::min(wanted, StackPagesLeft()); pages > 0) TouchStack(pages);
  // For this thread alone; lowering the priority is never refused.
  if (settings.nice > 0) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), settings.nice);
  if (settings.cpu && !BindTo(*settings.cpu)) {
    notices.push_back(fmt::format(
        "thread \"{}\" is not bound to processor {}, so it moves between processors; this process "
        "may not use that one: name another, or widen its CPU set",
        settings.name, *settings.cpu));
  }
  // Last, so that nothing above runs at this priority.
  if (settings.fifo_priority > 0 && !UseFifo(settings.fifo_priority)) {
    notices.push_back(fmt::format(
        "thread \"{}\" runs with the ordinary scheduler, so other programs can delay it by "
        "milliseconds; for SCHED_FIFO {} add \"@realtime - rtprio 99\" to "
        "/etc/security/limits.conf, join the group realtime, log in again",
        settings.name, settings.fifo_priority));
  }
  return notices;
}

StartedThread StartThread(const ThreadSettings& settings,
                          std::function<void(const std::stop_token&)> run) {
  std::promise<std::vector<std::string>> set_up;
  std::future<std::vector<std::string>> notices = set_up.get_future();
  std::jthread thread([settings, run = std::move(run),
                       set_up = std::move(set_up)](const std::stop_token& stop) mutable {
    try {
      set_up.set_value(SetUpThisThread(settings));
    } catch (...) {
      set_up.set_exception(std::current_exception());
      return;
    }
    run(stop);
  });
  std::vector<std::string> texts = notices.get();
  return {std::move(thread), std::move(texts)};
}

}  // namespace twin::rt
