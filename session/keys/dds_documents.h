// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session/keys/certificates.h"

/// The two documents of DDS Security, unsigned. Source: OMG DDS-SECURITY 1.1, 9.4.
namespace waymark::session::keys {

/// The rules for all: who is not authenticated stays out, discovery and data are encrypted, and
/// every topic is subject to permissions.
std::string GovernanceXml();

/// What one subject may do: partitions that it may write to and read from, wildcards allowed.
struct Grant {
  std::string subject;  ///< of its certificate, RFC 2253
  Validity validity;
  std::vector<std::string> writes, reads;
};
std::string PermissionsXml(const Grant& grant);

/// When permissions end, signed ones too; nothing where the text does not say so.
std::optional<WallTime> FindPermissionsEnd(std::string_view text);

}  // namespace waymark::session::keys
