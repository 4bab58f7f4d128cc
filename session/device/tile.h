// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "localiser/localiser.h"
#include "mapping/base/result.h"
#include "session/device/device_session.h"

namespace waymark::session {

/// A small map that a device carries, to localise by itself where the server is away: of one or a
/// few submaps, as `waymark-map summarise --submap ID --max-mb 0.95` writes it. Immutable,
/// thread-safe.
class Tile {
 public:
  /// Errors: those of the map directory and of Localiser::Create.
  static Result<std::shared_ptr<const Tile>> Open(const std::filesystem::path& folder);

  /// The map and release that it was cut from, whose poses its are.
  const SessionMap& map() const { return map_; }
  /// Takes as long as the server would, a tenth of a second on a laptop's core.
  localiser::Localisation Localise(const DeviceFrame& frame) const;

 private:
  Tile(SessionMap map, std::shared_ptr<const localiser::Localiser> localiser)
      : map_(std::move(map)), plane_(map_.origin), localiser_(std::move(localiser)) {}

  const SessionMap map_;
  const TangentPlane plane_;
  const std::shared_ptr<const localiser::Localiser> localiser_;
};

/// Against gravity, from the phone's sense of it or from its odometry, whose z is up. Unit.
Eigen::Vector3d UpInCamera(const DeviceFrame& frame);

}  // namespace waymark::session
