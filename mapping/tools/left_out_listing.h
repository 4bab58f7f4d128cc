// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

/// Prints images that are in no submap; those with the same fate share a line. Nothing for none.
void PrintLeftOut(std::span<const LeftOutImage> images);

}  // namespace waymark::mapping
