// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "session/state/messages.h"

namespace waymark::support {

/// A query that a localiser of the test's own answers: of the smallest camera, with one byte.
inline session::LocaliseQuery TinyQuery(std::uint32_t request) {
  const std::array<double, 3> parameters{1, 1, 1};
  return {.ticket = {},
          .request = session::RequestNumber{request},
          .time = {},
          .camera = *CameraModel::Create(CameraKind::kSimplePinhole, 2, 2, parameters),
          .prior = std::nullopt,
          .up_in_camera = std::nullopt,
          .image = {1}};
}

}  // namespace waymark::support
