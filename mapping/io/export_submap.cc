// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_submap.h"

#include "mapping/base/file.h"

namespace waymark::mapping {
namespace {

/// The model when the variant holds one.
const SubmapModel* AsModel(const std::variant<const SubmapModel*, const SubmapView*>& submap) {
  const auto* model = std::get_if<const SubmapModel*>(&submap);
  return model != nullptr ? *model : nullptr;
}

}  // namespace

std::span<const CameraModel> ExportSubmap::cameras() const {
  if (const SubmapModel* model = AsModel(submap_)) return model->cameras;
  return std::get<const SubmapView*>(submap_)->cameras();
}

std::span<const SubmapImage> ExportSubmap::images() const {
  if (const SubmapModel* model = AsModel(submap_)) return model->images;
  return std::get<const SubmapView*>(submap_)->images();
}

std::size_t ExportSubmap::landmark_count() const {
  if (const SubmapModel* model = AsModel(submap_)) return model->landmarks.size();
  return std::get<const SubmapView*>(submap_)->landmarks_in_submap().size();
}

Point<Submap> ExportSubmap::Landmark(std::size_t index) const {
  if (const SubmapModel* model = AsModel(submap_)) return model->landmarks[index];
  return Point<Submap>(std::get<const SubmapView*>(submap_)->landmarks_in_submap()[index]);
}

std::size_t ExportSubmap::observation_count() const {
  if (const SubmapModel* model = AsModel(submap_)) return model->observations.size();
  return std::get<const SubmapView*>(submap_)->descriptors().size();
}

ExportSubmap::Observation ExportSubmap::ObservationAt(std::size_t index) const {
  if (const SubmapModel* model = AsModel(submap_)) {
    const LandmarkObservation& o = model->observations[index];
    return {o.landmark, o.image, o.x_px, o.y_px};
  }
  const SubmapView& view = *std::get<const SubmapView*>(submap_);
  const PixelF pixel = view.observation_pixels()[index];
  return {view.observed_landmarks()[index], view.observing_images()[index], pixel.x_px, pixel.y_px};
}

Result<void> StoreExport(std::span<const ExportFile> files, const std::filesystem::path& folder) {
  WAYMARK_TRY(CreateFolders(folder));
  for (const ExportFile& file : files) {
    WAYMARK_TRY(StoreFileAtomically(folder / file.name, std::string_view(file.content)));
  }
  return {};
}

}  // namespace waymark::mapping
