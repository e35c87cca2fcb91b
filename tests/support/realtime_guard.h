#pragma once

#include <cstdint>

namespace twin::test {

/// Counts what real-time code must not do, on the thread that made it and while it lives: taking
/// memory, giving it back, and locking.
///
///     RealtimeGuard guard;
///     for (int i = 0; i < 1000; ++i) loop.Tick();
///     EXPECT_EQ(guard.allocations(), 0);
///
/// Counted are malloc and its family (operator new ends there), free, and pthread_mutex_lock and
/// pthread_rwlock_*lock (std::mutex and std::shared_mutex end there), whichever library of the
/// process calls them. free(nullptr) and a try-lock are not counted: they never wait. Several
/// guards may live at once; each counts from its own construction. A test program that links
/// twin_test_support has it; it also works under the sanitizers.
///
/// Threads: one thread; read it on the thread that made it. A gtest assertion that is evaluated
/// while the guard lives may itself allocate: when several figures are wanted, take them with
/// counts() first.
class RealtimeGuard {
 public:
  /// What happened since the guard was made.
  struct Counts {
    std::int64_t allocations = 0;
    std::int64_t frees = 0;
    std::int64_t locks = 0;
    bool operator==(const Counts&) const = default;
  };

  RealtimeGuard() noexcept;
  RealtimeGuard(const RealtimeGuard&) = delete;
  RealtimeGuard& operator=(const RealtimeGuard&) = delete;

  [[nodiscard]] Counts counts() const noexcept;
  [[nodiscard]] std::int64_t allocations() const noexcept { return counts().allocations; }
  [[nodiscard]] std::int64_t frees() const noexcept { return counts().frees; }
  [[nodiscard]] std::int64_t locks() const noexcept { return counts().locks; }

 private:
  Counts start_;
};

}  // namespace twin::test
