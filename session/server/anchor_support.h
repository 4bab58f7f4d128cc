// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "content_store/anchor_record.h"
#include "mapping/geometry/geodesy.h"
#include "session/server/attachments.h"

namespace waymark::session {

/// Reads a release of the map. NotFound when it is not kept any more.
using LoadRelease = std::function<Result<mapping::Release>(std::uint64_t epoch)>;

/// The releases that led to the live one, each read when it is first asked for, as far as they are
/// kept. Thread-compatible.
class ReleaseHistory {
 public:
  /// `before` was served before, if any was; `load` may be empty.
  ReleaseHistory(std::shared_ptr<const LiveRelease> live, std::shared_ptr<const LiveRelease> before,
                 LoadRelease load);

  const LiveRelease& live() const { return *live_; }
  /// From this epoch or the one served before on, oldest first, without the live one. The one
  /// served before comes last if it did not lead to the live one: then that is a step back.
  std::vector<std::shared_ptr<const LiveRelease>> Since(std::uint64_t epoch);

 private:
  std::shared_ptr<const LiveRelease> FindParent(const LiveRelease& of) const;

  const std::shared_ptr<const LiveRelease> live_, before_;
  const LoadRelease load_;
  std::vector<std::shared_ptr<const LiveRelease>> ancestors_;  // youngest first
  bool has_all_ = false;                                       // no older one is kept
};

/// The anchor as it must be stored so that it does not run out of submaps while releases replace
/// them one by one (see HoldIn); nullopt when it can stay as it is. One whose submaps are all gone
/// is taken through the releases between, and if no way leads to the live one it stays where it was
/// seen last and is marked unsupported.
std::optional<content::AnchorRecord> RenewSupport(const content::AnchorRecord& record,
                                                  ReleaseHistory& history,
                                                  const TangentPlane& map_plane);

}  // namespace waymark::session
