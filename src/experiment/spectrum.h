#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace twin::experiment {

/// One-sided power spectral density of a signal.
struct Spectrum {
  double step_hz = 0;           ///< between two values; the first is at 0 Hz
  std::vector<double> density;  ///< unit^2/Hz

  [[nodiscard]] double frequency_hz(std::size_t i) const noexcept {
    return static_cast<double>(i) * step_hz;
  }
};

/// Welch's estimate: the mean of the periodograms of segments of `segment` samples that overlap by
/// half, each less its mean and weighed with Hann's window; the density is scaled so that its
/// integral over all frequencies is the signal's variance. Source: Welch, "The use of fast Fourier
/// transform for the estimation of power spectra", IEEE Trans. Audio Electroacoust. 1967.
///
/// Threads: any. Real-time: no.
/// @param rate_hz  of the samples, > 0. @param segment  even, >= 2.
/// @returns no density when the signal is shorter than a segment.
[[nodiscard]] Spectrum Welch(std::span<const double> signal, double rate_hz, std::size_t segment);

/// Power of what lies between two frequencies, both inside: the sum of the densities there times
/// their step, unit^2.
[[nodiscard]] double BandPower(const Spectrum& spectrum, double from_hz, double to_hz) noexcept;

/// The same of each segment by itself, one after the other; the median of them, 0 of none. What a
/// signal does most of the time, whatever a part of it does.
[[nodiscard]] double MedianBandPower(std::span<const double> signal, double rate_hz,
                                     std::size_t segment, double from_hz, double to_hz);

/// Amplitude and phase of the sine of `frequency_hz` that fits the signal best, together with a
/// constant and a straight line: signal(i) ~ Re(A exp(j 2 pi f i / rate)) + c + d i. The ratio of
/// two signals' A is the frequency response from one to the other.
/// @pre at least 4 samples, and 0 < frequency_hz < rate_hz / 2.
[[nodiscard]] std::complex<double> SineAmplitude(std::span<const double> signal, double rate_hz,
                                                 double frequency_hz);

}  // namespace twin::experiment
