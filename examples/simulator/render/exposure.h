// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/render/renderer.h"

namespace waymark::simulator {

/// How a camera moves while its shutter is open.
struct CameraMotion {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();   ///< in the world
  Eigen::Vector3d turning_radps = Eigen::Vector3d::Zero();  ///< about the camera's axes
  double shutter = 1;  ///< it is open for so many of the lighting's `exposure_s`
};

/// What falls onto the sensor while the shutter is open, in the middle of which the camera is at
/// `world_from_camera`: the mean of up to eight looks, one for each pixel that it moves by.
Radiance RenderExposure(const Renderer& renderer, const ViewRays& rays,
                        const Rigid3& world_from_camera, const CameraMotion& motion,
                        Antialiasing antialiasing = Antialiasing::kEdges);

}  // namespace waymark::simulator
