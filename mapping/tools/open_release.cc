// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/open_release.h"

#include <utility>

namespace waymark::mapping {

std::vector<ExportSubmap> OpenRelease::Submaps() const {
  std::vector<ExportSubmap> submaps;
  for (std::size_t i = 0; i < views.size(); ++i) {
    submaps.emplace_back(views[i], release.submaps[i].map_from_submap);
  }
  return submaps;
}

Result<OpenRelease> LoadRelease(const std::filesystem::path& map_folder, std::uint64_t epoch) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(map_folder));
  WAYMARK_TRY_ASSIGN(Release release,
                     epoch == 0 ? map.LoadCurrentRelease() : map.LoadRelease(epoch));
  OpenRelease open{.origin = map.description().origin,
                   .is_geo_aligned = map.description().is_geo_aligned,
                   .release = std::move(release),
                   .views = {}};
  for (const ReleasedSubmap& submap : open.release.submaps) {
    WAYMARK_TRY_ASSIGN(SubmapView view, SubmapView::Open(map.SubmapPath(submap.id)));
    open.views.push_back(std::move(view));
  }
  return open;
}

}  // namespace waymark::mapping
