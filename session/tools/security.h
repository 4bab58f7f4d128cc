// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>

#include <filesystem>
#include <string>

#include "mapping/base/log.h"
#include "session/keys/expiry.h"

namespace waymark::session {

/// Whether an address is reached from this machine alone.
inline bool IsLoopback(const std::string& address) {
  in_addr parsed{};  // a name may begin with 127 and be anywhere
  if (::inet_pton(AF_INET, address.c_str(), &parsed) == 1) return ntohl(parsed.s_addr) >> 24 == 127;
  return address == "localhost" || address == "::1";
}

/// Whether a folder of keys has what DDS Security needs, beside what tokens need.
inline bool HasDdsCredentials(const std::string& folder) {
  return !folder.empty() && std::filesystem::exists(folder + "/certificate.pem");
}

inline void WarnOfExpiry(keys::ExpiryWatch& watch) {
  if (const auto warning = watch.TakeWarning(keys::WallNow())) LogWarning("{}", *warning);
}

}  // namespace waymark::session
