#include "twin/golden/signature.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "twin/core/error.h"

namespace twin::golden {
namespace {

bool IsSignature(const render::Image& image) {
  return image.width == kSignatureWidth && image.height == kSignatureHeight;
}

std::uint8_t MeanOfBox(const render::Image& picture, int column, int row, std::size_t channel) {
  const int left = column * picture.width / kSignatureWidth;
  const int right = (column + 1) * picture.width / kSignatureWidth;
  const int top = row * picture.height / kSignatureHeight;
  const int bottom = (row + 1) * picture.height / kSignatureHeight;
  std::uint32_t sum = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) sum += picture.rgb[picture.Offset(x, y) + channel];
  }
  const auto pixels = static_cast<std::uint32_t>((right - left) * (bottom - top));
  return static_cast<std::uint8_t>((sum + pixels / 2) / pixels);
}

/// Position of signature `i` in a strip: left and top, pixels.
std::pair<int, int> PlaceOf(std::size_t i) {
  const int number = static_cast<int>(i);
  return {number % kStripColumns * kSignatureWidth, number / kStripColumns * kSignatureHeight};
}

int StripHeight(std::size_t count) {
  return static_cast<int>((count + kStripColumns - 1) / kStripColumns) * kSignatureHeight;
}

}  // namespace

render::Image SignatureOf(const render::Image& picture) {
  TWIN_CHECK(picture.width >= kSignatureWidth && picture.height >= kSignatureHeight);
  render::Image signature(kSignatureWidth, kSignatureHeight);
  for (int row = 0; row < kSignatureHeight; ++row) {
    for (int column = 0; column < kSignatureWidth; ++column) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        signature.rgb[signature.Offset(column, row) + channel] =
            MeanOfBox(picture, column, row, channel);
      }
    }
  }
  return signature;
}

SignatureDifference CompareSignatures(const render::Image& expected, const render::Image& actual) {
  TWIN_CHECK(IsSignature(expected) && IsSignature(actual));
  SignatureDifference worst;
  for (std::size_t i = 0; i < expected.rgb.size(); ++i) {
    const int off = std::abs(int{expected.rgb[i]} - int{actual.rgb[i]});
    if (off <= worst.levels) continue;
    const int pixel = static_cast<int>(i / 3);
    worst = {off, pixel % kSignatureWidth, pixel / kSignatureWidth};
  }
  return worst;
}

render::Image JoinSignatures(std::span<const render::Image> signatures) {
  TWIN_CHECK(!signatures.empty());
  render::Image strip(kStripColumns * kSignatureWidth, StripHeight(signatures.size()));
  for (std::size_t i = 0; i < signatures.size(); ++i) {
    TWIN_CHECK(IsSignature(signatures[i]));
    const auto [left, top] = PlaceOf(i);
    for (int row = 0; row < kSignatureHeight; ++row) {
      const auto from = signatures[i].Row(row);
      std::copy(from.begin(), from.end(),
                strip.rgb.begin() + static_cast<std::ptrdiff_t>(strip.Offset(left, top + row)));
    }
  }
  return strip;
}

std::vector<render::Image> SplitSignatures(const render::Image& strip, std::size_t count) {
  if (strip.width != kStripColumns * kSignatureWidth || strip.height != StripHeight(count)) {
    return {};
  }
  std::vector<render::Image> signatures(count, render::Image(kSignatureWidth, kSignatureHeight));
  for (std::size_t i = 0; i < count; ++i) {
    const auto [left, top] = PlaceOf(i);
    for (int row = 0; row < kSignatureHeight; ++row) {
      const auto from = strip.Row(top + row).subspan(3 * static_cast<std::size_t>(left),
                                                     3 * std::size_t{kSignatureWidth});
      std::copy(from.begin(), from.end(), signatures[i].Row(row).begin());
    }
  }
  return signatures;
}

}  // namespace twin::golden
