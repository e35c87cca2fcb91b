#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>

struct osmesa_context;

namespace twin::render {

/// An OpenGL context without window or graphics card (Mesa's off-screen interface, llvmpipe).
///
/// MuJoCo draws into its own framebuffer object, so the buffer that OSMesa requires is a dummy.
///
/// Threads: any. In all the process one context is current at a time, since contexts of Mesa are
/// not independent: llvmpipe (22.3.6) asks each of them, unlocked, what it is drawing whenever one
/// maps a buffer, and MuJoCo keeps the table of OpenGL's functions in globals.
class OsMesaContext {
 public:
  /// While it lives, the context is current on this thread and other contexts wait. Drawing has
  /// ended when it ends.
  class Current {
   public:
    /// @throws EnvironmentError if OSMesa refuses, and in a fork.
    explicit Current(OsMesaContext& gl);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;

   private:
    const std::unique_lock<std::mutex> lock_;
  };

  /// @throws EnvironmentError if OSMesa gives no context, and in a fork of a process that had one.
  OsMesaContext();

  /// @returns whether contexts can be used: false in a fork of a process that had one.
  [[nodiscard]] static bool LivesHere() noexcept;

 private:
  static constexpr std::size_t kDummySize = 16;
  struct Destroy {
    void operator()(osmesa_context* context) const noexcept;
  };

  std::array<std::uint32_t, kDummySize * kDummySize> dummy_{};
  std::unique_ptr<osmesa_context, Destroy> context_;
};

}  // namespace twin::render
