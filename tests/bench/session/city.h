// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "content_store/anchor_store.h"
#include "mapping/store/release.h"

namespace waymark::bench {

/// Anchors that stand in the first room of a crowd from the beginning, in a square about the
/// origin.
struct CityAnchors {
  int count = 0;
  double edge_m = 0;
};

/// A release of the city's map: a submap every 60 m. From each release to the next all of them move
/// by the same 10 cm.
mapping::Release CityRelease(double edge_m, std::uint64_t epoch);

/// A store in a new file with these anchors, each attached to the three submaps next to it.
std::unique_ptr<content::AnchorStore> StoreCity(const CityAnchors& anchors,
                                                const std::filesystem::path& file);

}  // namespace waymark::bench
