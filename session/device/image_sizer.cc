// SPDX-License-Identifier: Apache-2.0
#include "session/device/image_sizer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace waymark::session {
namespace {

// Measured on pictures that are hard to find, relative to the largest; see README.md.
constexpr std::array kSteps{
    ImageStep{{.max_side_px = 320, .quality = 50}, 7.4e3, 0.70},
    ImageStep{{.max_side_px = 400, .quality = 50}, 11.3e3, 0.78},
    ImageStep{{.max_side_px = 480, .quality = 50}, 15.8e3, 0.87},
    ImageStep{{.max_side_px = 480, .quality = 75}, 24e3, 0.92},
    ImageStep{{.max_side_px = 640, .quality = 75}, 42e3, 0.94},
    ImageStep{{.max_side_px = 960, .quality = 75}, 85e3, 0.97},
    ImageStep{{.max_side_px = 1600, .quality = 85}, 220e3, 0.99},
};

constexpr double kFirstGuess = 8 / 3e6;  // seconds per byte before anything is known
constexpr std::size_t kRemembered = 5;
constexpr double kLeast = 8 / 1e9;  // no radio is faster

}  // namespace

std::span<const ImageStep> ImageSteps() { return kSteps; }

std::size_t ImageSizer::ExpectedBytes() const {
  return static_cast<std::size_t>(detail_ * kSteps[ChooseStep()].typical_bytes);
}

void ImageSizer::OnEncoded(const ImageSize& size, std::size_t bytes) {
  for (const ImageStep& step : kSteps) {
    // Frames that are smaller than a step say less than it would take, and are: no larger one is
    // to be had.
    if (step.size == size) detail_ = static_cast<double>(bytes) / step.typical_bytes;
  }
}

void ImageSizer::OnArrived(std::size_t bytes, double seconds) {
  if (bytes == 0) return;
  seconds_per_byte_.push_back(std::max(seconds / static_cast<double>(bytes), kLeast));
  if (seconds_per_byte_.size() > kRemembered) seconds_per_byte_.pop_front();
}

void ImageSizer::OnTooSlow() {
  // How slow is not known: at least twice as slow as thought.
  const double slow = 2 * SecondsPerByte();
  seconds_per_byte_.assign(seconds_per_byte_.empty() ? 1 : seconds_per_byte_.size(), slow);
}

void ImageSizer::OnAnswer(bool is_found) { not_found_ = is_found ? 0 : not_found_ + 1; }

/// The median: one image that met a lost packet says little.
double ImageSizer::SecondsPerByte() const {
  if (seconds_per_byte_.empty()) return kFirstGuess;
  std::deque<double> sorted = seconds_per_byte_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

std::size_t ImageSizer::ChooseStep() const {
  const double per_byte = SecondsPerByte();
  std::size_t best = 0;
  double least_s = INFINITY;
  for (std::size_t i = 0; i < kSteps.size(); ++i) {
    const double travel_s = detail_ * kSteps[i].typical_bytes * per_byte;
    // Where images are not found, this place is harder than the typical one.
    const double found = std::pow(kSteps[i].found_share, 1 + not_found_);
    const double until_found_s = travel_s + (1 / found - 1) * (interval_s_ + travel_s);
    if (until_found_s < least_s) {
      least_s = until_found_s;
      best = i;
    }
  }
  return best;
}

}  // namespace waymark::session
