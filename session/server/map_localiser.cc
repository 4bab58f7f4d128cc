// SPDX-License-Identifier: Apache-2.0
#include "session/server/map_localiser.h"

#include <algorithm>

namespace waymark::session {

double SearchRadius_m(double sigma_m) { return std::clamp(20 + 3 * sigma_m, 30.0, 2000.0); }

LocaliseFunction MakeLocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser,
                                      const mapping::MapDescription& map) {
  return [localiser = std::move(localiser), plane = TangentPlane(map.origin),
          is_geo_aligned =
              map.is_geo_aligned](const LocaliseQuery& query) -> Result<localiser::Localisation> {
    WAYMARK_TRY_ASSIGN(mapping::GrayImage image, mapping::DecodeGrayImage(query.image));
    std::optional<localiser::PositionPrior> prior;
    if (query.prior && is_geo_aligned) {
      prior = localiser::PositionPrior{.position = plane.ToMap(query.prior->position),
                                       .radius_m = SearchRadius_m(query.prior->sigma_m)};
    }
    return localiser->Localise({.image = std::move(image),
                                .camera = query.camera,
                                .prior = prior,
                                .up_in_camera = query.up_in_camera});
  };
}

}  // namespace waymark::session
