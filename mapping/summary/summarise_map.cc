// SPDX-License-Identifier: Apache-2.0
#include "mapping/summary/summarise_map.h"

#include <algorithm>
#include <optional>

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"

namespace waymark::mapping {
namespace {

Result<SummarisedSubmap> SummariseOne(const MapDirectory& map, const SubmapId& id,
                                      const MapDirectory& out, const SummaryOptions& options) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(map.SubmapPath(id)));
  WAYMARK_TRY_ASSIGN(const SubmapModel model, DecodeSubmap(bytes));
  const SubmapModel summary = Summarise(model, options);
  WAYMARK_TRY_ASSIGN(const auto summary_bytes, EncodeSubmap(summary));
  WAYMARK_TRY_ASSIGN(const SubmapId after, out.StoreSubmap(summary_bytes));
  return SummarisedSubmap{.before = id,
                          .after = after,
                          .bytes_before = bytes.size(),
                          .bytes_after = summary_bytes.size(),
                          .landmarks_before = model.landmarks.size(),
                          .landmarks_after = summary.landmarks.size(),
                          .descriptors_before = model.observations.size(),
                          .descriptors_after = summary.observations.size()};
}

}  // namespace

Result<std::vector<SummarisedSubmap>> SummariseMap(const MapDirectory& map, const Release& release,
                                                   const std::filesystem::path& out,
                                                   const SummaryOptions& options,
                                                   const Parallelism& parallelism) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(const MapDirectory small, MapDirectory::Create(out, map.description()));
  std::vector<std::optional<Result<SummarisedSubmap>>> outcomes(release.submaps.size());
  ParallelFor(outcomes.size(), parallelism, [&](std::size_t i) {
    outcomes[i] = SummariseOne(map, release.submaps[i].id, small, options);
  });
  Release small_release = release;
  small_release.parent_epoch = std::nullopt;
  std::vector<SummarisedSubmap> summarised;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    WAYMARK_TRY_ASSIGN(SummarisedSubmap one, *std::move(outcomes[i]));
    small_release.submaps[i].id = one.after;
    small_release.submaps[i].displacement = std::nullopt;
    summarised.push_back(std::move(one));
  }
  std::sort(small_release.submaps.begin(), small_release.submaps.end(),
            [](const ReleasedSubmap& a, const ReleasedSubmap& b) { return a.id < b.id; });
  WAYMARK_TRY(small.StoreRelease(small_release));
  WAYMARK_TRY(small.Deploy(small_release.epoch));
  return summarised;
}

}  // namespace waymark::mapping
