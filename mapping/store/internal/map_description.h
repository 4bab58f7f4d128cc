// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping::internal {

/// The description as it will be read back: options as compact JSON, an empty text as "{}".
/// Errors: InvalidArgument for an unusable id or origin, or options that are no JSON object.
Result<MapDescription> Canonical(const MapDescription& description);

/// map.json of a canonical description, and back. Errors: Corrupt, Unsupported.
std::string EncodeMapDescription(const MapDescription& description);
Result<MapDescription> DecodeMapDescription(std::string_view json, std::string_view name);

}  // namespace waymark::mapping::internal
