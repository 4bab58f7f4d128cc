// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/open_release.h"

#include <algorithm>
#include <map>
#include <optional>

#include "mapping/base/parallel.h"

namespace waymark::localiser::internal {
namespace {

// Balances ranking cells with scanning them: a submap keeps about two of five descriptors.
constexpr std::size_t kEntriesPerCell = 160;
constexpr std::size_t kMaxCells = 4096;

std::size_t LargestOf(std::span<const OpenSubmap> submaps) {
  std::size_t largest = 0;
  for (const OpenSubmap& submap : submaps) {
    largest = std::max(largest, submap.descriptors().size());
  }
  return largest;
}

/// One where all submaps are so small that they are scanned whole: no cell is ever asked for.
std::size_t WantedCells(std::size_t largest) {
  if (largest < LandmarkSearchOptions{}.exhaustive_below) return 1;
  return std::clamp<std::size_t>(largest / kEntriesPerCell, 1, kMaxCells);
}

}  // namespace

Result<std::vector<OpenSubmap>> OpenSubmaps(const mapping::MapDirectory& map,
                                            const mapping::Release& release,
                                            std::span<const OpenSubmap> shared) {
  std::map<SubmapId, const OpenSubmap*> known;
  for (const OpenSubmap& submap : shared) known.emplace(submap.released().id, &submap);
  std::vector<std::optional<Result<OpenSubmap>>> outcomes(release.submaps.size());
  ParallelFor(outcomes.size(), {}, [&](std::size_t i) {
    const mapping::ReleasedSubmap& released = release.submaps[i];
    const auto found = known.find(released.id);
    outcomes[i] = found != known.end() ? found->second->PlacedBy(released)
                                       : OpenSubmap::Open(map.SubmapPath(released.id), released);
  });
  std::vector<OpenSubmap> submaps;
  for (auto& outcome : outcomes) {
    WAYMARK_TRY_ASSIGN(OpenSubmap submap, *std::move(outcome));
    submaps.push_back(std::move(submap));
  }
  return submaps;
}

bool IsFineEnough(const CoarseQuantiser& quantiser, std::size_t largest) {
  constexpr std::size_t kTooCoarse = 4;  // times fewer cells than wanted
  return WantedCells(largest) <= kTooCoarse * quantiser.size();
}

std::shared_ptr<const CoarseQuantiser> TrainQuantiser(std::span<const OpenSubmap> submaps,
                                                      const LocaliserOptions& options) {
  std::vector<std::span<const mapping::Descriptor>> sets;
  std::size_t descriptors = 0;
  for (const OpenSubmap& submap : submaps) {
    sets.push_back(submap.descriptors());
    descriptors += sets.back().size();
  }
  if (descriptors == 0) {
    return std::make_shared<const CoarseQuantiser>(std::vector<mapping::Descriptor>(1));
  }
  return std::make_shared<const CoarseQuantiser>(
      CoarseQuantiser::Train(sets, WantedCells(LargestOf(submaps)), options.seed));
}

std::shared_ptr<const CoarseQuantiser> IndexSubmaps(std::vector<OpenSubmap>& submaps,
                                                    std::shared_ptr<const CoarseQuantiser> before,
                                                    const LocaliserOptions& options) {
  const bool is_fine = before != nullptr && IsFineEnough(*before, LargestOf(submaps));
  const auto quantiser = is_fine ? std::move(before) : TrainQuantiser(submaps, options);
  ParallelFor(submaps.size(), {}, [&](std::size_t i) {
    if (submaps[i].is_indexed() && is_fine) return;
    submaps[i].Index(*quantiser, options);
  });
  return quantiser;
}

}  // namespace waymark::localiser::internal
