// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include "mapping/base/id.h"
#include "mapping/base/result.h"

namespace waymark::session::keys {

/// What counts no more. As a text file: one `token ID`, `device UUID`, `key ID` or `gateway NAME`
/// a line; empty lines and those that begin with # mean nothing.
struct Revocations {
  std::set<std::string> tokens;
  std::set<DeviceId> devices;
  std::set<std::string> keys;
  std::set<std::string> gateways = {};

  /// Whose certificates count no more, as ReadCertificate names them.
  std::set<std::string> Names() const;

  friend bool operator==(const Revocations&, const Revocations&) = default;
};

/// Errors: InvalidArgument with the line's number: a list that is not understood must not pass for
/// a shorter one.
Result<Revocations> ParseRevocations(std::string_view text);
/// A file that is not there is an empty list. Errors: those of ParseRevocations, Unavailable.
Result<Revocations> LoadRevocations(const std::filesystem::path& path);
/// One more line, for example ("token", "0011223344556677"). Durable when it returns.
Result<void> AddRevocation(const std::filesystem::path& path, std::string_view what,
                           std::string_view id);

}  // namespace waymark::session::keys
