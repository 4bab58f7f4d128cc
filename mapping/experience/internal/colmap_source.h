// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"

namespace waymark::mapping::internal {

/// A table of a COLMAP model, binary or text. Reads one number or name after the other; the first
/// that is not there is the error: Corrupt, with file and line or byte.
class ColmapSource {
 public:
  virtual ~ColmapSource() = default;
  virtual Result<std::int64_t> Integer(std::string_view what) = 0;
  virtual Result<double> Number(std::string_view what) = 0;
  virtual Result<CameraKind> Kind() = 0;
  virtual Result<std::string> Name() = 0;  ///< the last field of an image's pose
  virtual Result<void> SkipPixels() = 0;
  /// Whether another record follows; moves to it.
  virtual Result<bool> Next() = 0;
  virtual std::string Where() const = 0;

  Error Wrong(std::string_view expected) const {
    return MakeError(ErrorCode::kCorrupt, "{}: expected {}", Where(), expected);
  }
};

enum class ColmapTable { kCameras, kImages };

/// Opens the binary table of a model, or the text one where there is none. Errors: NotFound.
Result<std::unique_ptr<ColmapSource>> OpenColmapTable(const std::filesystem::path& folder,
                                                      ColmapTable table);

}  // namespace waymark::mapping::internal
