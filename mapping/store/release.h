// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

/// How far a submap moved since the parent release, at its centroid.
struct Displacement {
  double translation_m = 0;
  double rotation_rad = 0;
  double scale_ratio = 1;
};

struct ReleasedSubmap {
  SubmapId id;
  Similarity<Map, Submap> map_from_submap;
  Point<Map> centre;         ///< of its cameras
  double radius_m = 0;       ///< all its cameras lie within
  double overlap_rms_m = 0;  ///< residual against images shared with other submaps
  double gnss_rms_m = 0;
  std::optional<Displacement> displacement;  ///< absent when the parent did not hold it
};

/// One version of the whole map. Immutable once written.
struct Release {
  std::uint64_t epoch = 1;  ///< >= 1, grows by one
  std::optional<std::uint64_t> parent_epoch;
  std::string created_utc;                        ///< ISO 8601
  std::vector<ReleasedSubmap> submaps;            ///< sorted by id
  std::optional<double> fusion_s = std::nullopt;  ///< how long placing the submaps took
};

/// Whether a text is a content hash: only then it may become a file name.
bool IsSubmapIdText(std::string_view text);

/// Pure codecs; doubles come back to the last bit, and decoding and encoding again gives the same
/// text. Decoding errors: Corrupt, Unsupported, with `name` as the object.
std::string EncodeRelease(const Release& release);
Result<Release> DecodeRelease(std::string_view json, std::string_view name);

}  // namespace waymark::mapping
