// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace waymark::session {

/// Whether an address is reached from this machine alone.
inline bool IsLoopback(const std::string& address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

/// Whether a folder of keys has what DDS Security needs, beside what tokens need.
inline bool HasDdsCredentials(const std::string& folder) {
  return !folder.empty() && std::filesystem::exists(folder + "/certificate.pem");
}

}  // namespace waymark::session
