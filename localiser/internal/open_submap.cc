// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/open_submap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/content_hash.h"
#include "mapping/base/mapped_file.h"

namespace waymark::localiser::internal {
namespace {

// A valid submap under another's name would be placed where the other one belongs.
Result<void> CheckName(const std::filesystem::path& path, const SubmapId& id) {
  WAYMARK_TRY_ASSIGN(const MappedFile file, MappedFile::Open(path));
  const std::string found = ContentHash(file.bytes());
  if (found == id.text()) return {};
  return MakeError(ErrorCode::kCorrupt, "{}: expected content with hash {}, found {}",
                   path.string(), id.text(), found);
}

}  // namespace

Result<void> OpenSubmap::CheckPlace(const mapping::ReleasedSubmap& released) {
  const Sim3& sim = released.map_from_submap.sim();
  const bool is_usable = std::isfinite(sim.scale()) && sim.scale() > 0 &&
                         sim.translation().allFinite() && sim.rotation().coeffs().allFinite() &&
                         released.centre.coordinates().allFinite() &&
                         std::isfinite(released.radius_m);
  if (is_usable) return {};
  return MakeError(ErrorCode::kCorrupt, "release: submap {} has no usable map_from_submap",
                   released.id.text());
}

namespace {

Result<void> CheckLandmarks(const std::filesystem::path& path, const mapping::SubmapView& view) {
  const auto landmarks = view.landmarks_in_submap();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (landmarks[i].allFinite()) continue;
    return MakeError(ErrorCode::kCorrupt, "{}: landmark {} is not finite", path.string(), i);
  }
  for (const std::uint32_t index : view.observed_landmarks()) {
    if (index < landmarks.size()) continue;
    return MakeError(ErrorCode::kCorrupt, "{}: expected a landmark below {}, found {}",
                     path.string(), landmarks.size(), index);
  }
  return {};
}

}  // namespace

Result<OpenSubmap> OpenSubmap::Open(const std::filesystem::path& path,
                                    const mapping::ReleasedSubmap& released) {
  WAYMARK_TRY(CheckPlace(released));
  WAYMARK_TRY(CheckName(path, released.id));
  WAYMARK_TRY_ASSIGN(mapping::SubmapView view, mapping::SubmapView::Open(path));
  WAYMARK_TRY(CheckLandmarks(path, view));
  return OpenSubmap(released, std::make_shared<const mapping::SubmapView>(std::move(view)));
}

Result<OpenSubmap> OpenSubmap::PlacedBy(const mapping::ReleasedSubmap& released) const {
  CHECK(released.id == released_.id, "{} is not {}", released.id.text(), released_.id.text());
  WAYMARK_TRY(CheckPlace(released));
  OpenSubmap placed = *this;
  placed.released_ = released;
  return placed;
}

void OpenSubmap::Index(const CoarseQuantiser& quantiser, const LocaliserOptions& options) {
  localiser_ =
      std::make_shared<const SubmapLocaliser>(view_->landmarks_in_submap(), view_->descriptors(),
                                              view_->observed_landmarks(), quantiser, options);
}

std::size_t OpenSubmap::bytes() const {
  constexpr std::size_t kSighting =
      sizeof(mapping::Descriptor) + 2 * sizeof(std::uint32_t) + sizeof(mapping::PixelF);
  return view_->landmarks_in_submap().size_bytes() + kSighting * view_->descriptors().size() +
         (localiser_ != nullptr ? localiser_->bytes() : 0);
}

}  // namespace waymark::localiser::internal
