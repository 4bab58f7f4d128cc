// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/geometry/camera_model.h"

namespace waymark {

/// Whether parameters begin with two focal lengths, of x and y, or with one of both; the principal
/// point follows.
constexpr bool HasTwoFocals(CameraKind kind) {
  return kind == CameraKind::kPinhole || kind == CameraKind::kOpenCv;
}

/// The kind of a pinhole that was given radial distortion, with the pinhole's parameters first;
/// other kinds as they are.
constexpr CameraKind WithRadialDistortion(CameraKind kind) {
  switch (kind) {
    case CameraKind::kSimplePinhole:
      return CameraKind::kRadial;
    case CameraKind::kPinhole:
      return CameraKind::kOpenCv;
    default:
      return kind;
  }
}

}  // namespace waymark
