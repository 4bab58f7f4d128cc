// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "session/wire/outbox.h"

namespace waymark::session::wire {

/// The poses of a tick, encoded once, of which the frames of many listeners are made. Immutable.
class PoseSheet {
 public:
  /// `tick` says when and of what; its own poses do not count.
  PoseSheet(const PoseBatch& tick, std::span<const SharedPose> poses);

  /// The frame of a batch with these poses of the sheet, as EncodeFrame would make it; at most
  /// kMaxPosesPerBatch.
  SharedFrame Frame(std::span<const std::uint32_t> chosen) const;

 private:
  std::vector<std::uint8_t> head_;   // the frame of a batch without poses
  std::vector<std::uint8_t> poses_;  // each as long as the others
};

}  // namespace waymark::session::wire
