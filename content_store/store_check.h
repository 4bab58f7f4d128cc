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
  std::uint64_t revision = 0;         ///< latest in the log
  std::size_t anchors = 0;            ///< live
  std::size_t deleted = 0;            ///< ids that are spent
  std::size_t superseded = 0;         ///< states that a later one replaced
  std::vector<std::string> problems;  ///< empty: sound; at most 100
};

/// Reads a whole SQLite store: SQLite's own integrity check, every checksum, the log without a gap,
/// the index in agreement with the log. Changes nothing. A store that cannot even be opened fails
/// with OpenSqliteStore's errors; what is damaged inside is a problem in the report.
Result<StoreCheck> CheckSqliteStore(const std::filesystem::path& file);

}  // namespace waymark::content
