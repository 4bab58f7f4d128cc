// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <span>

#include "session/device/jpeg.h"

namespace waymark::session {

/// One size that images may travel in.
struct ImageStep {
  ImageSize size;
  double typical_bytes;
  double found_share;  ///< of images that are found in the map when they travel so
};

/// The sizes to choose from, smallest first; where their figures come from: README.md.
std::span<const ImageStep> ImageSteps();

/// Chooses how large the next image is sent: so that, as the network has lately been, it is found
/// soonest on the average. A small one arrives early but may have to be followed by another; a
/// large one is found but arrives late. Pure; thread-compatible.
class ImageSizer {
 public:
  /// An image that is not found is followed by another after `interval`.
  explicit ImageSizer(std::chrono::duration<double> interval) : interval_s_(interval.count()) {}

  ImageSize Choose() const { return ImageSteps()[ChooseStep()].size; }
  /// Of an image of that size, as images have lately been.
  std::size_t ExpectedBytes() const;

  void OnEncoded(const ImageSize& size, std::size_t bytes);
  /// An image arrived, so many seconds later than a message of no size would have.
  void OnArrived(std::size_t bytes, double seconds);
  /// An image was given up before it arrived.
  void OnTooSlow();
  /// The server looked for an image.
  void OnAnswer(bool is_found);

 private:
  std::size_t ChooseStep() const;
  double SecondsPerByte() const;

  double interval_s_;
  double detail_ = 1;                    ///< bytes of these images over the typical ones
  std::deque<double> seconds_per_byte_;  ///< of the latest images
  int not_found_ = 0;                    ///< in a row
};

}  // namespace waymark::session
