// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "mapping/fusion/internal/overlap.h"
#include "mapping/fusion/internal/radix_sort.h"

namespace waymark::mapping {
namespace {

/// An image in a submap.
struct Sighting {
  std::uint64_t image;
  std::uint32_t submap;
  std::uint32_t index;
};

/// By image, then submap.
Result<LargeVector<Sighting>> SortSightings(std::span<const FusionSubmap> submaps) {
  std::size_t count = 0;
  for (const FusionSubmap& submap : submaps) count += submap.images.size();
  LargeVector<Sighting> sightings;
  sightings.reserve(count);
  for (std::uint32_t s = 0; s < submaps.size(); ++s) {
    for (std::uint32_t i = 0; i < submaps[s].images.size(); ++i) {
      sightings.push_back({submaps[s].images[i].image, s, i});
    }
  }
  // They come by submap and index, and stay so where they are of one image.
  RadixSort(sightings, [](const Sighting& sighting) { return sighting.image; });
  const auto same = std::ranges::adjacent_find(sightings, [](const Sighting& a, const Sighting& b) {
    return a.image == b.image && a.submap == b.submap;
  });
  if (same != sightings.end()) {
    return MakeError(ErrorCode::kInvalidArgument, "fusion: submap {} holds image {} twice",
                     same->submap, same->image);
  }
  return sightings;
}

/// That a later submap holds an image, too.
struct Partner {
  std::uint32_t second;
  SharedImage image;
};

/// Sorts all partners of a submap into its overlaps.
void AppendOverlaps(std::uint32_t first, std::vector<Partner>& partners,
                    std::vector<Overlap>& overlaps) {
  std::ranges::sort(partners, {}, [](const Partner& partner) {
    return std::uint64_t{partner.second} << 32 | partner.image.in_second;
  });
  for (auto begin = partners.begin(), end = begin; begin != partners.end(); begin = end) {
    end = std::find_if(begin, partners.end(),
                       [&](const Partner& partner) { return partner.second != begin->second; });
    overlaps.push_back({first, begin->second, {}});
    overlaps.back().images.reserve(static_cast<std::size_t>(end - begin));
    for (auto partner = begin; partner != end; ++partner) {
      overlaps.back().images.push_back(partner->image);
    }
  }
}

}  // namespace

Result<std::vector<Overlap>> FindOverlaps(std::span<const FusionSubmap> submaps) {
  WAYMARK_TRY_ASSIGN(const LargeVector<Sighting> sightings, SortSightings(submaps));
  // Where each image of each submap is among them.
  LargeVector<std::uint32_t> place_of(sightings.size());
  std::vector<std::size_t> begin_of(submaps.size() + 1, 0);
  for (std::size_t s = 0; s < submaps.size(); ++s) {
    begin_of[s + 1] = begin_of[s] + submaps[s].images.size();
  }
  for (std::uint32_t k = 0; k < sightings.size(); ++k) {
    place_of[begin_of[sightings[k].submap] + sightings[k].index] = k;
  }
  std::vector<Overlap> overlaps;
  std::vector<Partner> partners;
  for (std::uint32_t s = 0; s < submaps.size(); ++s) {
    partners.clear();
    for (std::uint32_t i = 0; i < submaps[s].images.size(); ++i) {
      const std::uint32_t place = place_of[begin_of[s] + i];
      for (std::size_t k = place + std::size_t{1};
           k < sightings.size() && sightings[k].image == sightings[place].image; ++k) {
        partners.push_back({sightings[k].submap, {i, sightings[k].index}});
      }
    }
    AppendOverlaps(s, partners, overlaps);
  }
  return overlaps;
}

}  // namespace waymark::mapping
