// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "localiser/localiser.h"
#include "tests/localiser/map_on_disk.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser {

inline const Sim3 kMapFromSubmap(1.02, RotationFromVector({0, 0, 0.3}), {100, -40, 2});

/// A release on disk and a place that some of its submaps show.
class LocaliserTest : public testing::Test {
 protected:
  std::shared_ptr<const Localiser> Open(const LocaliserOptions& options = {}) {
    const auto localiser = Localiser::Create(disk_.map(), disk_.release(), options);
    CHECK(localiser.ok(), "{}", ToString(localiser.error()));
    return *localiser;
  }
  LocalisationRequest Request(const Rigid3& place_from_camera, int clutter = 200) {
    return {place_.Photo(place_from_camera, clutter), TestCamera(), std::nullopt, std::nullopt};
  }

  RandomPlace place_{1};
  MapOnDisk disk_;
};

}  // namespace waymark::localiser
