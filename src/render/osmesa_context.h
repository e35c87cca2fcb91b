#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

struct osmesa_context;

namespace twin::render {

/// An OpenGL context without window or graphics card (Mesa's off-screen interface, llvmpipe).
///
/// MuJoCo draws into its own framebuffer object, so the buffer that OSMesa requires is a dummy.
///
/// Threads: a context is current on at most one thread at a time.
class OsMesaContext {
 public:
  /// @throws EnvironmentError if OSMesa gives no context, and in a fork of a process that had one.
  OsMesaContext();

  /// @returns whether contexts can be used: false in a fork of a process that had one.
  [[nodiscard]] static bool LivesHere() noexcept;

  /// Makes this context current on the calling thread.
  /// @throws EnvironmentError if OSMesa refuses, and in a fork.
  void MakeCurrent();

  /// Releases the calling thread's context, so that another thread may use it.
  static void ReleaseCurrent() noexcept;

 private:
  static constexpr std::size_t kDummySize = 16;
  struct Destroy {
    void operator()(osmesa_context* context) const noexcept;
  };

  std::array<std::uint32_t, kDummySize * kDummySize> dummy_{};
  std::unique_ptr<osmesa_context, Destroy> context_;
};

}  // namespace twin::render
