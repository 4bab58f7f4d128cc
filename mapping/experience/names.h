// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace waymark::mapping {

/// Whether bytes are UTF-8 without control characters, so that they may stand in logs, JSON and
/// file names.
bool IsPrintableText(std::string_view text);

/// Whether a text may be an ExperienceId: printable, 1 to 200 bytes, one file name that is neither
/// hidden nor a path.
bool IsExperienceIdText(std::string_view text);

/// Whether a text may name an image: a printable relative path of at most 1,000 bytes, parts
/// separated by '/', none of them empty, "." or ".."; it cannot leave its folder.
bool IsImageName(std::string_view text);

}  // namespace waymark::mapping
