// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/summaries.h"

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "mapping/summary/summarise.h"

namespace waymark::evaluation {

Result<std::vector<mapping::ReleasedSubmap>> StoreSummaries(
    const mapping::MapDirectory& map, std::vector<mapping::ReleasedSubmap> submaps,
    std::size_t max_bytes) {
  for (mapping::ReleasedSubmap& placed : submaps) {
    WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(map.SubmapPath(placed.id)));
    WAYMARK_TRY_ASSIGN(const mapping::SubmapModel whole, mapping::DecodeSubmap(bytes));
    WAYMARK_TRY_ASSIGN(const auto small,
                       mapping::EncodeSubmap(Summarise(whole, {.max_bytes = max_bytes})));
    WAYMARK_TRY_ASSIGN(placed.id, map.StoreSubmap(small));
  }
  return submaps;
}

}  // namespace waymark::evaluation
