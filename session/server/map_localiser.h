// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "localiser/localiser.h"
#include "mapping/geometry/geodesy.h"
#include "session/server/localise_pool.h"
#include "session/server/unfound_images.h"

namespace waymark::session {

/// How wide to search around a prior of this uncertainty: three sigma and the extent of a place.
double SearchRadius_m(double sigma_m);

/// Answers images from a release: decodes a picture or, where the phone has found them itself, its
/// features as mapping/features/feature_codec.h has them; places the prior in the map, asks the
/// localiser. What is not found alone is asked once more together with the earlier images that the
/// query names, as far as `unfound` has them; releases may share it. Null: each image is asked
/// alone, and none is kept.
LocaliseFunction MakeLocaliseFunction(std::shared_ptr<const localiser::Localiser> localiser,
                                      const mapping::MapDescription& map,
                                      std::shared_ptr<UnfoundImages> unfound = nullptr);

}  // namespace waymark::session
