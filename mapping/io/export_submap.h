// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"
#include "mapping/io/submap_file.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping {

/// A submap and where it lies in the map, as exports take it. Borrows the submap.
///
/// A whole release is exported by giving all its submaps. An image that stands in several of them
/// appears once: where it is not borrowed, else in the first that holds it.
class ExportSubmap {
 public:
  struct Observation {
    std::uint32_t landmark;
    std::uint32_t image;
    float x_px;
    float y_px;
  };

  ExportSubmap(const SubmapModel& model, const Similarity<Map, Submap>& map_from_submap)
      : submap_(&model), map_from_submap_(map_from_submap) {}
  ExportSubmap(const SubmapView& view, const Similarity<Map, Submap>& map_from_submap)
      : submap_(&view), map_from_submap_(map_from_submap) {}

  ExportSubmap(SubmapModel&&, const Similarity<Map, Submap>&) = delete;
  ExportSubmap(SubmapView&&, const Similarity<Map, Submap>&) = delete;

  const Similarity<Map, Submap>& map_from_submap() const { return map_from_submap_; }
  std::span<const CameraModel> cameras() const;
  std::span<const SubmapImage> images() const;
  std::size_t landmark_count() const;
  Point<Submap> Landmark(std::size_t index) const;
  std::size_t observation_count() const;
  Observation ObservationAt(std::size_t index) const;

 private:
  std::variant<const SubmapModel*, const SubmapView*> submap_;
  Similarity<Map, Submap> map_from_submap_;
};

/// A file to write, its content in memory.
struct ExportFile {
  std::string name;
  std::string content;
};

/// Writes exported files into a folder, which is made when it is not there.
Result<void> StoreExport(std::span<const ExportFile> files, const std::filesystem::path& folder);

}  // namespace waymark::mapping
