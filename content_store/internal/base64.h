// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace waymark::content::internal {

/// RFC 4648, section 4, with padding.
std::string EncodeBase64(std::string_view bytes);
/// Nothing if the text is not exactly what EncodeBase64 would write.
std::optional<std::string> DecodeBase64(std::string_view text);

}  // namespace waymark::content::internal
