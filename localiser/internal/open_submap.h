// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "localiser/internal/submap_localiser.h"
#include "mapping/base/result.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/release.h"

namespace waymark::localiser::internal {

/// A submap of the release, mapped and indexed. Immutable once indexed, thread-safe; copies share
/// everything but the place.
class OpenSubmap {
 public:
  /// Opens without an index. Errors: those of SubmapView; Corrupt when the bytes are not what the
  /// id, their content hash, says, when the release gives no usable transform, or when a landmark
  /// is not finite.
  static Result<OpenSubmap> Open(const std::filesystem::path& path,
                                 const mapping::ReleasedSubmap& released);

  /// The same submap, without reading it again, where another release places it.
  /// Errors: Corrupt when that release gives no usable transform.
  Result<OpenSubmap> PlacedBy(const mapping::ReleasedSubmap& released) const;

  /// Makes it searchable by this quantiser's cells. Copies keep the index they have.
  void Index(const CoarseQuantiser& quantiser, const LocaliserOptions& options);

  /// Errors: Corrupt when the release gives no usable transform.
  static Result<void> CheckPlace(const mapping::ReleasedSubmap& released);

  const mapping::ReleasedSubmap& released() const { return released_; }
  std::span<const mapping::Descriptor> descriptors() const { return view_->descriptors(); }
  const mapping::SubmapView& view() const { return *view_; }
  std::size_t bytes() const;  ///< in memory, the file's own pages included
  bool is_indexed() const { return localiser_ != nullptr; }
  const SubmapLocaliser& localiser() const { return *localiser_; }

 private:
  OpenSubmap(mapping::ReleasedSubmap released, std::shared_ptr<const mapping::SubmapView> view)
      : released_(std::move(released)), view_(std::move(view)) {}

  mapping::ReleasedSubmap released_;
  std::shared_ptr<const mapping::SubmapView> view_;  // outlives the localiser, which borrows
  std::shared_ptr<const SubmapLocaliser> localiser_;
};

}  // namespace waymark::localiser::internal
