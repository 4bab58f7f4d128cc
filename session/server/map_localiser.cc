// SPDX-License-Identifier: Apache-2.0
#include "session/server/map_localiser.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "mapping/features/feature_codec.h"

namespace waymark::session {
namespace {

// What EncodeFeatures begins with, and no picture.
bool AreFeatures(std::span<const std::uint8_t> content) {
  constexpr std::string_view kMagic = "WAYMFEAT";
  return content.size() >= kMagic.size() &&
         std::equal(kMagic.begin(), kMagic.end(), content.begin());
}

}  // namespace

double SearchRadius_m(double sigma_m) { return std::clamp(20 + 3 * sigma_m, 30.0, 2000.0); }

LocaliseFunction MakeLocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser,
                                      const mapping::MapDescription& map) {
  return [localiser = std::move(localiser), plane = TangentPlane(map.origin),
          is_geo_aligned =
              map.is_geo_aligned](const LocaliseQuery& query) -> Result<localiser::Localisation> {
    localiser::LocalisationRequest request{
        .image = {}, .camera = query.camera, .prior = {}, .up_in_camera = query.up_in_camera};
    if (AreFeatures(query.image)) {
      WAYMARK_TRY_ASSIGN(request.image, mapping::DecodeFeatures(query.image));
    } else {
      WAYMARK_TRY_ASSIGN(request.image, mapping::DecodeGrayImage(query.image));
    }
    if (query.prior && is_geo_aligned) {
      request.prior = localiser::PositionPrior{.position = plane.ToMap(query.prior->position),
                                               .radius_m = SearchRadius_m(query.prior->sigma_m)};
    }
    return localiser->Localise(request);
  };
}

}  // namespace waymark::session
