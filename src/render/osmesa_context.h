#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

struct osmesa_context;

namespace twin::render {

/// An OpenGL context without window or graphics card (Mesa's off-screen interface, llvmpipe).
///
/// MuJoCo draws into a framebuffer object of its own, so the buffer that OSMesa wants is a dummy.
///
/// Threads: a context is current on at most one thread at a time.
class OsMesaContext {
 public:
  /// @throws EnvironmentError when OSMesa gives no context.
  OsMesaContext();

  /// Makes this the calling thread's context.
  /// @throws EnvironmentError when OSMesa refuses.
  void MakeCurrent();

  /// Leaves the calling thread without a context, so that another may take this one.
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
