// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace waymark::content {

/// A store of some 45,000 revisions is compacted again and again by processes that are killed
/// (SIGKILL) at arbitrary moments, with writes in between: every anchor stays as it was, the store
/// is sound after each, and a compaction that is left alone ends with one state for each anchor.
void KillCompactions(const std::string& location, int trials);

}  // namespace waymark::content
