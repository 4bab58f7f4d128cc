// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark::content::internal {

/// A statement to prepare.
struct PostgresQuery {
  const char* name;
  std::string text;
};

/// All that every write and read runs. Rows come and go as arrays, so that the number of statements
/// does not grow with theirs.
std::vector<PostgresQuery> PostgresQueries();

}  // namespace waymark::content::internal
