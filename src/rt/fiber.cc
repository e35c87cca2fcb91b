#include "twin/rt/fiber.h"

#include <sys/mman.h>
#include <ucontext.h>

#include <cxxabi.h>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <utility>

#include "twin/core/error.h"

#if defined(__SANITIZE_ADDRESS__)
#define TWIN_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TWIN_ADDRESS_SANITIZER 1
#endif
#endif
#ifdef TWIN_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#endif

namespace twin::rt {
namespace {

/// Tells the address sanitizer which stack runs; nothing without it.
class SwitchOfStacks {
 public:
  /// Before a switch. @param saved  of the stack that is left; null: it is left for good.
  static void Start([[maybe_unused]] void** saved, [[maybe_unused]] const void* bottom,
                    [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef TWIN_ADDRESS_SANITIZER
    __sanitizer_start_switch_fiber(saved, bottom, bytes);
#endif
  }
  /// After it, on the other stack. @param saved  of this stack when it was left.
  /// @param bottom, bytes  receive the stack that was left; may be null.
  static void Finish([[maybe_unused]] void* saved, [[maybe_unused]] const void** bottom,
                     [[maybe_unused]] std::size_t* bytes) noexcept {
#ifdef TWIN_ADDRESS_SANITIZER
    __sanitizer_finish_switch_fiber(saved, bottom, bytes);
#endif
  }
  /// The last frames of a stack were left for good, and its memory may become another's.
  static void Forget([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef TWIN_ADDRESS_SANITIZER
    __asan_unpoison_memory_region(memory, bytes);
#endif
  }
};

/// What the C++ runtime keeps of a thread's exceptions: those being handled and the number of those
/// under way. Each fiber has its own, since it may yield while one unwinds its stack.
class ExceptionState {
 public:
  /// Exchanges it with the thread's.
  void Swap() noexcept {
    std::array<std::byte, kSize> mine = bytes_;
    std::memcpy(bytes_.data(), abi::__cxa_get_globals(), kSize);
    std::memcpy(abi::__cxa_get_globals(), mine.data(), kSize);
  }

 private:
  // Itanium C++ ABI, 2.2.2: a pointer and an unsigned int.
  static constexpr std::size_t kSize = sizeof(void*) + sizeof(unsigned int);
  std::array<std::byte, kSize> bytes_{};
};

constexpr std::size_t kGuard = 4096;

}  // namespace

struct Fiber::State {
  std::function<void()> body;
  ucontext_t own{};
  ucontext_t caller{};
  State* outer = nullptr;  ///< the fiber that resumed this one, if one did
  void* memory = nullptr;
  std::size_t bytes = 0;
  // For SwitchOfStacks.
  void* own_saved = nullptr;
  void* caller_saved = nullptr;
  const void* caller_bottom = nullptr;
  std::size_t caller_bytes = 0;
  ExceptionState exceptions;
  std::exception_ptr failure;
  bool begun = false;
  bool ended = false;

  void Enter() noexcept {
    SwitchOfStacks::Finish(nullptr, &caller_bottom, &caller_bytes);
    try {
      body();
    } catch (...) {
      failure = std::current_exception();
    }
    ended = true;
    Leave();
  }
  void Leave() noexcept;
};

namespace {

thread_local Fiber::State* running = nullptr;

/// makecontext() passes ints only.
void Begin(unsigned int high, unsigned int low) {
  const auto address = (static_cast<std::uintptr_t>(high) << 32U) | low;
  reinterpret_cast<Fiber::State*>(address)->Enter();  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace

void Fiber::State::Leave() noexcept {
  running = outer;
  exceptions.Swap();
  SwitchOfStacks::Start(ended ? nullptr : &own_saved, caller_bottom, caller_bytes);
  swapcontext(&own, &caller);
  SwitchOfStacks::Finish(own_saved, &caller_bottom, &caller_bytes);
}

Fiber::Fiber(std::function<void()> body, std::size_t stack_bytes)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.body = std::move(body);
  state.bytes = stack_bytes + kGuard;
  state.memory = ::mmap(nullptr, state.bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK | MAP_NORESERVE, -1, 0);
  if (state.memory == MAP_FAILED) {
    throw EnvironmentError("there is no memory for the stack of another robot's run");
  }
  ::mprotect(state.memory, kGuard, PROT_NONE);  // an overflow faults
  getcontext(&state.own);
  state.own.uc_stack.ss_sp = static_cast<std::byte*>(state.memory) + kGuard;
  state.own.uc_stack.ss_size = stack_bytes;
  const auto address = reinterpret_cast<std::uintptr_t>(&state);
  makecontext(&state.own, reinterpret_cast<void (*)()>(&Begin), 2,
              static_cast<unsigned int>(address >> 32U), static_cast<unsigned int>(address));
}

Fiber::~Fiber() {
  TWIN_CHECK(state_->ended || !state_->begun);
  SwitchOfStacks::Forget(state_->memory, state_->bytes);
  ::munmap(state_->memory, state_->bytes);
}

bool Fiber::ended() const noexcept {
  return state_->ended;
}

void Fiber::Resume() {
  State& state = *state_;
  TWIN_CHECK(!state.ended && running != &state);
  state.begun = true;
  state.outer = std::exchange(running, &state);
  state.exceptions.Swap();
  SwitchOfStacks::Start(&state.caller_saved, static_cast<std::byte*>(state.memory) + kGuard,
                        state.bytes - kGuard);
  swapcontext(&state.caller, &state.own);
  SwitchOfStacks::Finish(state.caller_saved, nullptr, nullptr);
  if (state.failure) std::rethrow_exception(std::exchange(state.failure, nullptr));
}

void Fiber::Yield() noexcept {
  running->Leave();
}

void ResumeInTurn(std::deque<Fiber>& fibers) {
  for (bool goes_on = true; goes_on;) {
    goes_on = false;
    for (Fiber& fiber : fibers) {
      if (fiber.ended()) continue;
      goes_on = true;
      fiber.Resume();
    }
  }
}

}  // namespace twin::rt
