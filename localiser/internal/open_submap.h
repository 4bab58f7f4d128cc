// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "localiser/internal/submap_localiser.h"
#include "mapping/base/result.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/release.h"

namespace waymark::localiser::internal {

/// A submap of the release, mapped and indexed. Immutable, thread-safe.
class OpenSubmap {
 public:
  /// Errors: those of SubmapView; Corrupt when the bytes are not what the id, their content hash,
  /// says, when the release gives no usable transform, or when a landmark is not finite.
  static Result<OpenSubmap> Open(const std::filesystem::path& path,
                                 const mapping::ReleasedSubmap& released,
                                 const LocaliserOptions& options);

  const mapping::ReleasedSubmap& released() const { return released_; }
  const SubmapLocaliser& localiser() const { return *localiser_; }

 private:
  OpenSubmap(mapping::ReleasedSubmap released, std::unique_ptr<const mapping::SubmapView> view)
      : released_(std::move(released)), view_(std::move(view)) {}

  mapping::ReleasedSubmap released_;
  std::unique_ptr<const mapping::SubmapView> view_;  // outlives the localiser, which borrows
  std::unique_ptr<const SubmapLocaliser> localiser_;
};

}  // namespace waymark::localiser::internal
