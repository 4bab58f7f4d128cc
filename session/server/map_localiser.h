// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "localiser/localiser.h"
#include "mapping/geometry/geodesy.h"
#include "session/server/localise_pool.h"

namespace waymark::session {

/// How wide to search around a prior of this uncertainty: three sigma and the extent of a place.
double SearchRadius_m(double sigma_m);

/// Answers images from a release: decodes a picture or, where the phone has found them itself, its
/// features as mapping/features/feature_codec.h has them; places the prior in the map, asks the
/// localiser.
LocaliseFunction MakeLocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser,
                                      const mapping::MapDescription& map);

}  // namespace waymark::session
