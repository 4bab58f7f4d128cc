// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/geometry/angle.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"
#include "mapping/store/map_directory.h"

namespace waymark::localiser {

/// Where the phone believes to be, from its GNSS. Heights are not compared.
struct PositionPrior {
  Point<Map> position;
  /// Submaps whose circle comes within this are searched; a pose beyond this is refused.
  double radius_m = 50;
};

/// One question. The image is either pixels or features taken by the phone.
struct LocalisationRequest {
  std::variant<mapping::GrayImage, mapping::ImageFeatures> image;
  CameraModel camera;
  std::optional<PositionPrior> prior;           ///< absent: every submap is searched
  std::optional<Eigen::Vector3d> up_in_camera;  ///< unit, from the phone's gravity
};

/// One image of a burst.
struct BurstImage {
  LocalisationRequest request;
  /// Odometry of gravity-aligned metres, z up; taken as exact to 2 % of the way to the last image.
  Transform<Vo, Camera> vo_from_camera;
};

/// What is asked where a burst's images give no pose; with kNone the last must take part in one.
enum class BurstFallback : std::uint8_t { kLastAlone, kNone };

/// Images that a phone took within seconds, asked as one: landmarks that no single image shows
/// enough of may be enough together. The answer is about the last one.
struct BurstRequest {
  static constexpr std::size_t kMinImages = 2;
  static constexpr std::size_t kMaxImages = 16;

  std::vector<BurstImage> images;  ///< oldest first
  BurstFallback fallback = BurstFallback::kLastAlone;
};

enum class LocalisationStatus : std::uint8_t {
  kLocalised,
  kTooFewFeatures,    ///< the image shows too little
  kNothingNear,       ///< no submap within the prior's radius
  kTooFewMatches,     ///< nothing in the map looks like it
  kNoConsistentPose,  ///< matches agree on no pose, on two, or gravity or prior contradicts it
  kInvalidRequest,    ///< the request contradicts itself, for example image and camera in size
};

std::string_view LocalisationStatusName(LocalisationStatus status);  ///< "localised", …

struct StageTimes {
  double opening_ms = 0;  ///< waiting for submaps that were not in memory
  double features_ms = 0;
  double search_ms = 0;
  double pose_ms = 0;
  double total_ms = 0;
};

/// The pose of the image with its evidence.
struct LocalisedPose {
  Transform<Map, Camera> map_from_camera;
  Eigen::Matrix<double, 6, 6> covariance;        ///< of Perturb's delta in the map frame, m and rad
  SubmapId submap;                               ///< the one that won
  Transform<Submap, Camera> submap_from_camera;  ///< survives every later release
  int inliers = 0;                               ///< of a burst: different landmarks
  double rms_px = 0;
  int images = 1;  ///< of a burst, that show inliers
  /// Whose images show most of the inliers' landmarks; absent in answers that came over a network.
  std::optional<ExperienceId> experience = std::nullopt;
};

/// One answer: a value also when there is no pose.
struct Localisation {
  LocalisationStatus status = LocalisationStatus::kTooFewFeatures;
  std::string reason;  ///< one sentence with figures
  std::uint64_t epoch = 0;
  std::optional<LocalisedPose> pose;  ///< present exactly when kLocalised
  StageTimes times;
};

/// How the landmark that a feature shows is looked for; lists are faster and find more.
enum class SearchMethod : std::uint8_t { kInvertedLists, kKdTrees };

struct LocaliserOptions {
  /// Phone frames are smaller; photos are reduced, which made a 6 MP one 4 times faster and no less
  /// exact.
  mapping::FeatureOptions features{.max_features = 2000, .max_image_side_px = 1600};
  int min_inliers = 15;     ///< fewer is no pose; 15 keeps chance agreement below 1 in 10^4
  double max_error_px = 6;  ///< reprojection error of an inlier
  /// Doubt about a request's focal length: where the matches contradict it, another is taken.
  double focal_sigma_share = 0.05;
  SearchMethod search = SearchMethod::kInvertedLists;
  /// Inverted lists of a submap that a feature looks into; more find more, and take longer.
  std::size_t probes = 16;
  double max_ratio = 0.85;  ///< angle to the best landmark over the best of another one
  Angle max_gravity_error = Angle::Degrees(4);  ///< phones and submaps are each good to 2
  /// Of submaps in memory, with the pages of their files; 0: no limit, all are opened at once.
  /// With one, a submap is opened when a request needs it, and that request waits: an answer from
  /// what happens to be open would depend on who asked before, and copies of a place that lie in
  /// the others would go unseen. What requests under way use comes on top of the budget.
  std::size_t memory_budget_bytes = 0;
  std::uint64_t seed = 1;

  Result<void> Validate() const;
};

/// What submaps take of the memory. Releases that share submaps share these figures.
struct LocaliserMemory {
  std::size_t budget_bytes = 0;  ///< 0: no limit
  std::size_t resident_bytes = 0;
  std::size_t peak_bytes = 0;  ///< of resident_bytes
  std::size_t resident_submaps = 0;
  std::uint64_t openings = 0;  ///< while serving
  std::uint64_t evictions = 0;
  double opening_ms = 0;  ///< of all openings together
};

/// Answers requests against one release. Immutable, thread-safe: many threads may ask at once.
/// Deterministic for a given request, release and options.
class Localiser {
 public:
  /// Opens every submap of the release and indexes its descriptors, on all cores; calls the C
  /// library's srand. With a memory budget it opens them to check them, and closes them again; then
  /// a submap whose file is gone later is left out of answers, whose reason says so. With `before`,
  /// made with the same options for another release of the map, submaps that both have are shared
  /// with it: only new ones are read. Errors: those of the map directory and its submaps; Corrupt
  /// when a file is not what its name, a content hash, says or the release places it nowhere.
  static Result<std::shared_ptr<const Localiser>> Create(const mapping::MapDirectory& map,
                                                         const mapping::Release& release,
                                                         const LocaliserOptions& options,
                                                         const Localiser* before = nullptr);
  ~Localiser();

  std::uint64_t epoch() const;
  std::size_t submap_count() const;
  const LocaliserOptions& options() const;
  LocaliserMemory memory() const;
  Localisation Localise(const LocalisationRequest& request) const;
  /// Solves for all images of a burst at once. Where no pose explains them together, as when only
  /// the last one shows the map or odometry contradicts what images show by themselves, the answer
  /// is that of the last image alone, unless the burst wants no fallback; `LocalisedPose::images`
  /// is 1 then, and `reason` says why.
  Localisation Localise(const BurstRequest& burst) const;

 private:
  struct Impl;

  explicit Localiser(std::unique_ptr<const Impl> impl);

  std::unique_ptr<const Impl> impl_;
};

}  // namespace waymark::localiser
