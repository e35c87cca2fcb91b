#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/ros2/cdr.h"

namespace twin::ros2 {

/// Gives each field of a message a value of its own; sequences 1 to 3 elements, so that alignments
/// differ.
class Filler {
 public:
  void operator()(std::string_view /*name*/, auto& field) { Fill(field); }

  void Fill(Message auto& message) {
    std::remove_cvref_t<decltype(message)>::Visit(message, *this);
  }
  template <Number T>
  void Fill(T& value) {
    value = static_cast<T>(++count_ % 100);
  }
  void Fill(std::string& text) { text = std::string(++count_ % 7, 'x'); }
  template <std::size_t N>
  void Fill(BoundedString<N>& text) {
    Fill(text.text);
  }
  template <typename T, std::size_t N>
  void Fill(std::array<T, N>& elements) {
    for (T& element : elements) Fill(element);
  }
  template <typename T>
  void Fill(std::vector<T>& elements) {
    elements.resize(1 + ++count_ % 3);
    for (T& element : elements) Fill(element);
  }

 private:
  unsigned count_ = 0;
};

template <Message M>
[[nodiscard]] M Filled() {
  M message;
  Filler().Fill(message);
  return message;
}

}  // namespace twin::ros2
