// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::content {

/// What a store holds and what is wrong with it.
struct StoreCheck {
  std::uint64_t revision = 0;           ///< latest in the log
  std::uint64_t compacted_through = 0;  ///< up to here superseded states are gone
  std::size_t anchors = 0;              ///< live
  std::size_t deleted = 0;              ///< ids that are spent
  std::size_t superseded = 0;           ///< states that a later one replaced
  std::vector<std::string> problems;    ///< empty: sound; at most 100
};

/// Reads a whole store: the database's own check of its structure, every checksum, the log without
/// a gap, the index and the owners' usage in agreement with the log. Changes nothing. A store that
/// cannot even be opened fails with OpenStore's errors; what is damaged inside is a problem in the
/// report.
Result<StoreCheck> CheckStore(const std::string& location);
Result<StoreCheck> CheckSqliteStore(const std::filesystem::path& file);

}  // namespace waymark::content
