// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/prune.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "mapping/base/median.h"
#include "mapping/submap/internal/drives_past.h"
#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping {
namespace {

constexpr double kMinGnssErrorM = 3;  // nearer than this, doubt the receiver rather than the image

using Reasons = std::map<std::uint32_t, std::string>;

/// How far a registered image is from its GNSS position, once what is common to all of them is
/// taken out.
struct GnssDistance {
  std::uint32_t image;
  Eigen::Vector3d gnss_in_submap;
  double metres;
};

std::vector<GnssDistance> MeasureGnss(const Reconstruction& reconstruction,
                                      std::span<const VerificationImage> images) {
  std::vector<GnssDistance> distances;
  std::vector<Eigen::Vector3d> offsets;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    const auto& pose = reconstruction.images[i].submap_from_camera;
    if (!pose || !images[i].gnss_in_submap) continue;
    distances.push_back({i, images[i].gnss_in_submap->coordinates(), 0});
    offsets.push_back(pose->translation() - images[i].gnss_in_submap->coordinates());
  }
  if (offsets.empty()) return distances;
  Eigen::Vector3d common;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& offset : offsets) values.push_back(offset[axis]);
    common[axis] = Median(std::move(values));
  }
  for (std::size_t k = 0; k < offsets.size(); ++k)
    distances[k].metres = (offsets[k] - common).norm();
  return distances;
}

// Where those around it are off too, the whole is bent, or GNSS is.
bool StandsAlone(const GnssDistance& suspect, std::vector<GnssDistance> others) {
  constexpr std::size_t kNeighbours = 2;
  constexpr double kMuchNearer = 0.5;
  std::erase_if(others, [&](const GnssDistance& other) { return other.image == suspect.image; });
  if (others.size() < kNeighbours) return false;
  const auto from_suspect = [&](const GnssDistance& other) {
    return (other.gnss_in_submap - suspect.gnss_in_submap).norm();
  };
  std::ranges::partial_sort(others, others.begin() + kNeighbours, {}, from_suspect);
  return std::ranges::all_of(std::span(others).first(kNeighbours), [&](const GnssDistance& other) {
    return other.metres < kMuchNearer * suspect.metres;
  });
}

void CheckGnss(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
               const VerificationOptions& options, Reasons& reasons) {
  if (!reconstruction.is_geo_aligned) return;
  const std::vector<GnssDistance> distances = MeasureGnss(reconstruction, images);
  for (const GnssDistance& one : distances) {
    const double sigmas = one.metres / images[one.image].gnss_sigma_m;
    if (one.metres > kMinGnssErrorM && sigmas > options.max_gnss_sigmas &&
        StandsAlone(one, distances)) {
      reasons.try_emplace(one.image,
                          fmt::format("registered {:.1f} m from its GNSS position, {:.0f} "
                                      "standard deviations",
                                      one.metres, sigmas));
    }
  }
}

/// All pictures of a drive past that stand elsewhere than those of the others do.
void CheckDrives(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                 const VerificationOptions& options, Reasons& reasons) {
  if (!reconstruction.is_geo_aligned) return;
  for (const internal::DisplacedDrive& drive :
       internal::FindDisplacedDrives(internal::CollectDrivesPast(reconstruction, images),
                                     kMinGnssErrorM, options.max_gnss_sigmas)) {
    const std::string reason =
        fmt::format("its drive past stands {:.1f} m from its GNSS positions and the others do not",
                    drive.metres);
    for (const std::uint32_t image : drive.images) reasons.insert_or_assign(image, reason);
  }
}

/// How many of an image's tests against its neighbours there are and failed.
struct Votes {
  int tests = 0;
  int failures = 0;
};

void CondemnByVotes(std::span<const Votes> votes, const std::string& reason, Reasons& reasons) {
  for (std::uint32_t i = 0; i < votes.size(); ++i) {
    // Against one neighbour alone it is open which of the two is wrong.
    if (votes[i].tests >= 2 && votes[i].failures == votes[i].tests) reasons.try_emplace(i, reason);
  }
}

void CheckNeighbours(const Reconstruction& reconstruction,
                     std::span<const VerificationImage> images,
                     std::span<const MeasuredRotation> rotations,
                     const VerificationOptions& options, Reasons& reasons) {
  std::vector<Votes> turned(images.size());
  for (const auto& check : internal::CompareRotations(reconstruction, rotations, options)) {
    for (const std::uint32_t image : {check.from, check.to}) {
      ++turned[image].tests;
      turned[image].failures += check.value > check.bound;
    }
  }
  CondemnByVotes(turned, "turned against the gyroscope on both sides", reasons);
  if (!reconstruction.is_geo_aligned) return;
  std::vector<Votes> displaced(images.size());
  for (const auto& check : internal::MeasureSpeeds(reconstruction, images, options)) {
    for (const std::uint32_t image : {check.from, check.to}) {
      ++displaced[image].tests;
      displaced[image].failures += check.value > check.bound;
    }
  }
  CondemnByVotes(displaced, "faster than a vehicle on both sides", reasons);
}

}  // namespace

Result<std::vector<ImplausibleImage>> FindImplausibleImages(
    const Reconstruction& reconstruction, std::span<const VerificationImage> images,
    std::span<const MeasuredRotation> rotations, const VerificationOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY(internal::CheckVerificationInput(reconstruction, images, rotations));
  Reasons reasons;
  CheckGnss(reconstruction, images, options, reasons);
  CheckNeighbours(reconstruction, images, rotations, options, reasons);
  const auto registered = std::ranges::count_if(
      reconstruction.images,
      [](const ReconstructedImage& image) { return image.submap_from_camera.has_value(); });
  if (10 * reasons.size() > static_cast<std::size_t>(registered)) reasons.clear();
  CheckDrives(reconstruction, images, options, reasons);
  std::vector<ImplausibleImage> found;
  for (auto& [image, reason] : reasons) found.push_back({image, std::move(reason)});
  return found;
}

void RemoveImages(std::span<const ImplausibleImage> images, Reconstruction& reconstruction) {
  for (const ImplausibleImage& image : images) {
    ReconstructedImage& removed = reconstruction.images[image.image];
    removed.submap_from_camera.reset();
    removed.exclusion = image.reason;
  }
  for (ReconstructedPoint& point : reconstruction.points) {
    std::erase_if(point.track, [&](const TrackElement& element) {
      return !reconstruction.images[element.image].submap_from_camera;
    });
  }
  std::erase_if(reconstruction.points,
                [](const ReconstructedPoint& point) { return point.track.size() < 2; });
}

}  // namespace waymark::mapping
