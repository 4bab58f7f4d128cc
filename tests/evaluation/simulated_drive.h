// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "examples/simulator/motion/motion.h"
#include "mapping/experience/experience.h"
#include "mapping/submap/verify.h"
#include "mapping/synthetic/capture.h"

namespace waymark::evaluation {

/// How the recorder moved.
enum class Route {
  kStraight,    ///< a car down a street, weaving within its lane
  kBend,        ///< a long bend
  kCorner,      ///< a right or left turn at a crossing
  kStopAndGo,   ///< down to walking pace and up again, with bends
  kTwoCameras,  ///< a weaving car with a second camera that looks left
  kOnFoot,      ///< a person who looks around and walks in curves
};
inline constexpr int kRoutes = 6;

/// A recording on its way to become a submap: what one camera rig saw and felt, with the truth.
/// Between making it and `Build`, faults may be planted in what was recorded.
struct SimulatedDrive {
  Route route;
  simulator::Motion motion;
  mapping::World world;
  std::vector<Rigid3> body_from_camera;  ///< by camera
  std::vector<std::uint32_t> camera_of_image;
  std::vector<double> seconds;     ///< by image: its stamp
  std::vector<Rigid3> true_poses;  ///< by image: at its stamp
  std::vector<Rigid3> seen_from;   ///< by image: where its picture was taken
  mapping::Experience experience;  ///< sensors and their records; no images
  std::uint64_t seed;

  double duration_s() const { return seconds.back(); }
};

/// Realistic in the same way as the simulated city: its inertial unit and its receiver.
SimulatedDrive MakeDrive(Route route, std::uint64_t seed);

/// A reconstruction with what verification is told about its images.
struct BuiltSubmap {
  mapping::Reconstruction reconstruction;
  std::vector<mapping::VerificationImage> images;
  std::vector<std::optional<Eigen::Quaterniond>> next_from_this;  ///< by image; gyroscope
  std::vector<Rigid3> true_poses;

  /// Between the images that are registered now.
  std::vector<mapping::MeasuredRotation> Rotations() const;
};

/// A rolling shutter, and what reconstruction is told of it.
struct Shutter {
  double readout_s = 0;
  double stated_readout_s = 0;
};

/// Captures, matches and reconstructs with noise and wrong matches; sensors pass through the
/// pipeline's own sensing. Errors: those of ReconstructIncrementally.
Result<BuiltSubmap> Build(const SimulatedDrive& drive, const Shutter& shutter = {});

/// Takes out single images that cannot be right, then judges, as the pipeline does.
Result<mapping::VerificationEvidence> PruneAndVerify(BuiltSubmap& submap,
                                                     const mapping::VerificationOptions& options);

/// Poses against the truth after the best similarity that most of them agree on.
struct PoseErrors {
  int images = 0;
  int wrong = 0;  ///< by more than 0.3 m or 1 degree
  double p90_m = 0;
  double p90_rad = 0;
  double lean_rad = 0;  ///< of its vertical: what the similarity makes good

  /// More than a tenth of its images are wrong, or the whole leans by more than 5 degrees.
  bool IsBroken() const { return 10 * wrong > images || lean_rad > 0.0873; }
};
PoseErrors CompareWithTruth(const BuiltSubmap& submap);

}  // namespace waymark::evaluation
