// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "session/keys/certificates.h"

namespace waymark::session::keys {

/// When something of a folder of keys counts no more.
struct Ending {
  std::filesystem::path file;
  std::string name;  ///< of whom or what it is
  WallTime until{};
};

/// What ends of the folder of an authority, of what it has issued, and of a folder that was issued,
/// each as far as it is there; ordered by file. Tokens are kept nowhere and so not in it.
/// Errors: Corrupt (a certificate that cannot be read), Unavailable.
Result<std::vector<Ending>> ListEndings(const std::filesystem::path& folder);

/// Says in time that the credentials of a server or gateway are about to end. Thread-compatible.
class ExpiryWatch {
 public:
  /// `kind` is what `waymark-keys issue` calls whose folder it is: "server" or "gateway". An empty
  /// folder: there are none.
  ExpiryWatch(std::filesystem::path folder, std::string kind)
      : folder_(std::move(folder)), kind_(std::move(kind)) {}

  /// Errors: InvalidArgument when something has ended, with the file, the time and what renews it;
  /// those of ListEndings.
  Result<void> CheckNow(WallTime now) const;
  /// A warning where something ends within two weeks or has ended, once a day; the folder is looked
  /// at each time, for it may have been renewed.
  std::optional<std::string> TakeWarning(WallTime now);

 private:
  std::string Describe(const Ending& ending, WallTime now) const;

  std::filesystem::path folder_;
  std::string kind_;
  std::optional<WallTime> warned_;
};

}  // namespace waymark::session::keys
