// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "mapping/base/result.h"
#include "mapping/io/internal/submap_layout.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping::internal {

/// A model whose small parts are decoded and whose landmarks and observations are still bytes.
struct SubmapParts {
  SubmapModel model;  ///< landmarks and observations empty
  SubmapSections sections;
};

/// Reads a file. Its small parts are checked whole; with kEverything also the large sections'
/// checksums, indices, order and finiteness, otherwise only that they lie in the file and have
/// matching sizes. Errors: Corrupt, Unsupported, with `name` as the object.
Result<SubmapParts> ReadSubmapParts(std::span<const std::uint8_t> bytes, std::string_view name,
                                    Checking checking);

}  // namespace waymark::mapping::internal
