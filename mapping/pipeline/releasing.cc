// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/releasing.h"

#include <Eigen/SVD>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "mapping/base/time.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/release_diff.h"

namespace waymark::mapping {
namespace {

/// How well z points up: by an accelerometer, or only by the plane of GNSS fixes.
constexpr double kMeasuredGravitySigmaRad = 0.02;
constexpr double kAssumedGravitySigmaRad = 0.1;

/// Numbers for images: the same (experience, name) has the same number everywhere.
class ImageNumbers {
 public:
  std::uint64_t NumberOf(const SubmapImage& image) {
    return numbers_.try_emplace({image.experience, image.name}, numbers_.size()).first->second;
  }

 private:
  std::map<std::pair<ExperienceId, std::string>, std::uint64_t> numbers_;
};

FusionSubmap ToFusion(const SubmapView& view, const TangentPlane& plane, bool is_geo_map,
                      ImageNumbers& numbers) {
  FusionSubmap submap;
  submap.map_from_enu = Similarity<Map, Submap>(MapFromEnu(plane, view.origin()));
  submap.is_geo_aligned = is_geo_map && view.is_geo_aligned();
  if (submap.is_geo_aligned) {
    submap.gravity_sigma_rad = view.evidence().max_gravity_error_rad > 0 ? kMeasuredGravitySigmaRad
                                                                         : kAssumedGravitySigmaRad;
  }
  submap.scale_sigma = view.scale_sigma();
  for (const SubmapImage& image : view.images()) {
    FusionImage fused{.image = numbers.NumberOf(image),
                      .submap_from_camera = image.submap_from_camera,
                      .gnss_in_map = {},
                      .gnss_sigma_m = image.gnss_sigma_m};
    if (image.gnss && submap.is_geo_aligned) fused.gnss_in_map = plane.ToMap(*image.gnss);
    submap.images.push_back(std::move(fused));
  }
  return submap;
}

ReleasedSubmap ToReleased(const SubmapId& id, const FusionSubmap& submap,
                          const FusedSubmap& fused) {
  const Sim3& place = fused.map_from_submap->sim();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const FusionImage& image : submap.images) {
    centre +=
        place * image.submap_from_camera.translation() / static_cast<double>(submap.images.size());
  }
  double radius_m = 0;
  for (const FusionImage& image : submap.images) {
    radius_m = std::max(radius_m, (place * image.submap_from_camera.translation() - centre).norm());
  }
  ReleasedSubmap released{.id = id,
                          .map_from_submap = *fused.map_from_submap,
                          .centre = Point<Map>(centre),
                          .radius_m = radius_m,
                          .overlap_rms_m = fused.overlap_rms_m,
                          .gnss_rms_m = fused.gnss_rms_m,
                          .displacement = {}};
  if (submap.previous) {
    released.displacement = Displacement{fused.moved_m, fused.turned_rad, fused.scale_ratio};
  }
  return released;
}

/// Root mean square over the submaps, each weighing as much as it has residuals.
double CombineRms(std::span<const FusedSubmap> submaps, double FusedSubmap::*rms,
                  int FusedSubmap::*count) {
  double squares = 0;
  int total = 0;
  for (const FusedSubmap& submap : submaps) {
    squares += submap.*count * submap.*rms * submap.*rms;
    total += submap.*count;
  }
  return total > 0 ? std::sqrt(squares / total) : 0;
}

Result<std::optional<Release>> LoadParent(const MapDirectory& map) {
  WAYMARK_TRY_ASSIGN(const auto epoch, map.LoadCurrentEpoch());
  if (!epoch) return std::optional<Release>();
  WAYMARK_TRY_ASSIGN(Release release, map.LoadRelease(*epoch));
  return std::optional<Release>(std::move(release));
}

bool HoldSameSubmaps(const Release& a, const Release& b) {
  return std::ranges::equal(a.submaps, b.submaps, {}, &ReleasedSubmap::id, &ReleasedSubmap::id);
}

Result<std::vector<FusionSubmap>> LoadFusionInput(const MapDirectory& map,
                                                  const std::set<SubmapId>& submaps,
                                                  const std::optional<Release>& parent, Run& run) {
  StageCounter counter(run, PipelineStage::kFusion, "map", submaps.size());
  std::map<SubmapId, Similarity<Map, Submap>> previous;
  if (parent) {
    for (const ReleasedSubmap& submap : parent->submaps) {
      previous.emplace(submap.id, submap.map_from_submap);
    }
  }
  const TangentPlane plane(map.description().origin);
  ImageNumbers numbers;
  std::vector<FusionSubmap> inputs;
  for (const SubmapId& id : submaps) {
    WAYMARK_TRY_ASSIGN(const SubmapView view,
                       SubmapView::Open(map.SubmapPath(id), SubmapReading::kImagesOnly));
    inputs.push_back(ToFusion(view, plane, map.description().is_geo_aligned, numbers));
    if (const auto found = previous.find(id); found != previous.end()) {
      inputs.back().previous = found->second;
    }
    counter.Add();
  }
  return inputs;
}

/// Whether two releases say the same, apart from when they were made: places within a micrometre.
bool AreSame(const Release& a, const Release& b) {
  constexpr double kMaxMovedM = 1e-6;
  if (a.parent_epoch != b.parent_epoch || !HoldSameSubmaps(a, b)) return false;
  const ReleaseDiff diff = CompareReleases(a, b);
  return std::ranges::all_of(diff.moved, [](const MovedSubmap& submap) {
    return submap.displacement.translation_m < kMaxMovedM;
  });
}

/// Stores a release under the next epoch, or finds it stored as the newest one.
Result<std::uint64_t> StoreAsNext(const MapDirectory& map, Release release) {
  WAYMARK_TRY_ASSIGN(const auto epochs, map.ListReleaseEpochs());
  if (!epochs.empty()) {
    WAYMARK_TRY_ASSIGN(const Release newest, map.LoadRelease(epochs.back()));
    if (AreSame(newest, release)) return newest.epoch;
    release.epoch = newest.epoch + 1;
  }
  WAYMARK_TRY(map.StoreRelease(release));
  return release.epoch;
}

}  // namespace

Sim3 MapFromEnu(const TangentPlane& map, const GeoPoint& origin) {
  const TangentPlane enu(origin);
  const auto to_map = [&](const Eigen::Vector3d& x_in_enu) {
    return map.ToMap(enu.ToGeo(Point<Map>(x_in_enu))).coordinates();
  };
  // A rigid motion: three axes tell it; 100 m keeps rounding below a nanoradian.
  const Eigen::Vector3d base = to_map(Eigen::Vector3d::Zero());
  Eigen::Matrix3d axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = (to_map(100 * Eigen::Vector3d::Unit(i)) - base) / 100;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  return {1, Eigen::Quaterniond(rotation), base};
}

Result<NewRelease> ReleaseSubmaps(const MapDirectory& map, const std::set<SubmapId>& submaps,
                                  const FusionOptions& options, std::string_view created_utc,
                                  ReleaseUntil until, Run& run) {
  const auto begun = std::chrono::steady_clock::now();
  WAYMARK_TRY_ASSIGN(const std::optional<Release> parent, LoadParent(map));
  WAYMARK_TRY_ASSIGN(const std::vector<FusionSubmap> inputs,
                     LoadFusionInput(map, submaps, parent, run));
  WAYMARK_TRY_ASSIGN(const Fusion fusion, UpdateFusion(inputs, options));

  NewRelease result{.epoch = {}, .unplaced = {}};
  Release release{.epoch = 1,
                  .parent_epoch = parent ? std::optional(parent->epoch) : std::nullopt,
                  .created_utc = std::string(created_utc),
                  .submaps = {}};
  std::size_t i = 0;
  for (const SubmapId& id : submaps) {
    const FusedSubmap& fused = fusion.submaps[i];
    if (fused.map_from_submap) {
      release.submaps.push_back(ToReleased(id, inputs[i], fused));
    } else {
      result.unplaced.push_back(id);
    }
    ++i;
  }
  if (release.submaps.empty()) {
    return MakeError(ErrorCode::kNotFound, "none of {} submaps has a place in the map",
                     submaps.size());
  }
  if (parent && HoldSameSubmaps(*parent, release)) return result;
  release.fusion_s = Seconds(std::chrono::steady_clock::now() - begun);
  WAYMARK_TRY_ASSIGN(result.epoch, StoreAsNext(map, std::move(release)));
  if (until == ReleaseUntil::kLive) WAYMARK_TRY(map.Deploy(*result.epoch));
  result.overlap_rms_m =
      CombineRms(fusion.submaps, &FusedSubmap::overlap_rms_m, &FusedSubmap::shared_images);
  result.gnss_rms_m =
      CombineRms(fusion.submaps, &FusedSubmap::gnss_rms_m, &FusedSubmap::gnss_images);
  return result;
}

Result<std::uint64_t> ReleaseInPlace(const MapDirectory& map, const std::set<SubmapId>& submaps,
                                     std::string_view created_utc, ReleaseUntil until) {
  WAYMARK_TRY_ASSIGN(Release release, map.LoadCurrentRelease());
  release.parent_epoch = std::exchange(release.epoch, 1);
  release.created_utc = std::string(created_utc);
  release.fusion_s = std::nullopt;
  std::erase_if(release.submaps,
                [&](const ReleasedSubmap& submap) { return !submaps.contains(submap.id); });
  for (ReleasedSubmap& submap : release.submaps) submap.displacement = Displacement{};
  WAYMARK_TRY_ASSIGN(const std::uint64_t epoch, StoreAsNext(map, std::move(release)));
  if (until == ReleaseUntil::kLive) WAYMARK_TRY(map.Deploy(epoch));
  return epoch;
}

}  // namespace waymark::mapping
