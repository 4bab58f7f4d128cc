// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/evaluation/localisation/judging.h"

namespace waymark::evaluation {

/// Which maps are asked, and with how many pictures that should not, or hardly, be found in them.
struct FalseAcceptsPlan {
  FalseAcceptsPlan() {
    car.drive.length_m = 120;
    car.spacing_m = 1.6;
  }

  simulator::CityOptions city;
  simulator::CarOptions car;
  simulator::PhoneOptions phone;
  std::vector<simulator::LightPreset> mapped{simulator::LightPreset::kDay,
                                             simulator::LightPreset::kEvening};
  std::vector<simulator::LightPreset> asked{
      simulator::LightPreset::kDay, simulator::LightPreset::kRain, simulator::LightPreset::kNight,
      simulator::LightPreset::kLowSunAgainst};
  int submaps_per_drive = 2;
  int walkers = 4;
  int keyframes_per_walk = 15;  ///< of every light
  PhoneSenses senses;
  double gravity_share = 0.5;    ///< of the requests that state it
  std::filesystem::path photos;  ///< JPEG and PNG files of real places below it; empty: none
  std::string only;              ///< kinds whose name contains this
  std::uint64_t seed = 1;
};

/// Shrinks the plan to what a test can afford.
void MakeQuick(FalseAcceptsPlan& plan);

/// A map that can be asked.
struct MappedPlace {
  std::shared_ptr<const localiser::Localiser> localiser;
  std::vector<Eigen::Vector3d> cameras_in_map;  ///< where claims of being there may point
};

/// A picture that is asked about.
struct Shown {
  std::filesystem::path kept;  ///< where its features are kept
  std::function<Result<mapping::GrayImage>()> load;
  CameraModel camera;
  Rigid3 map_from_camera;  ///< Nowhere() when no answer is right
};

/// Farther off than any map reaches: every answer is false.
Rigid3 Nowhere();

/// Where requests say that they are.
enum class Claim { kTrue, kInTheMap, kFarFromTruth, kNone };

/// Pictures of one kind that are asked of one map, each with several claims.
struct Batch {
  std::string kind;
  const MappedPlace* place;
  std::vector<Shown> pictures;
  Claim claim = Claim::kTrue;
  int claims = 1;           ///< requests per picture
  double focal_factor = 1;  ///< on the stated focal length
};

/// Maps, pictures and batches of a plan; batches point to places.
struct FalseAcceptTrials {
  std::vector<std::unique_ptr<MappedPlace>> places;
  std::vector<Batch> batches;
  std::size_t distinct_pictures = 0;  ///< rendered or photographed, before damage and repetition
};

/// Draws and maps; what the workshop holds already is not done again.
Result<FalseAcceptTrials> PrepareFalseAccepts(const FalseAcceptsPlan& plan,
                                              const Workshop& workshop);

/// Asks everything; `report` is called with every batch and its verdicts as soon as they are known,
/// and may be empty.
Result<std::vector<Verdict>> RunFalseAccepts(
    const FalseAcceptsPlan& plan, const FalseAcceptTrials& trials, const Workshop& workshop,
    const std::function<void(const std::vector<Verdict>&)>& report = {});

/// One line of the table, and what every false pose said.
std::string DescribeKind(const std::string& kind, const std::vector<Verdict>& verdicts);
std::string DescribeFalsePoses(const std::vector<Verdict>& verdicts);
/// The table by kind as text, and as one JSON document.
std::string DescribeFalseAccepts(const FalseAcceptTrials& trials,
                                 const std::vector<Verdict>& verdicts);
std::string EncodeFalseAccepts(const FalseAcceptTrials& trials,
                               const std::vector<Verdict>& verdicts);

}  // namespace waymark::evaluation
