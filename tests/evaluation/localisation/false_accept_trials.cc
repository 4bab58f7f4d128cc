// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "mapping/base/content_hash.h"
#include "tests/evaluation/localisation/false_accepts.h"
#include "tests/evaluation/localisation/picture_damage.h"
#include "tests/evaluation/localisation/shown_pictures.h"
#include "tests/evaluation/localisation/true_pose_map.h"

namespace waymark::evaluation {
namespace {

using simulator::LightPreset;
using simulator::Random;

/// Collects what a plan asks; draws as it goes.
class Preparation {
 public:
  Preparation(const FalseAcceptsPlan& plan, const Workshop& workshop)
      : plan_(plan), workshop_(workshop) {}

  Result<FalseAcceptTrials> Prepare() &&;

 private:
  bool IsAsked(const std::string& kind) const { return kind.find(plan_.only) != std::string::npos; }
  bool IsAnyAsked(const std::vector<std::string>& kinds) const {
    return std::any_of(kinds.begin(), kinds.end(), [&](auto& kind) { return IsAsked(kind); });
  }
  Result<const MappedPlace*> MapPlace(const simulator::CityOptions& city,
                                      const simulator::CarOptions& car,
                                      const std::vector<LightPreset>& lights, int submaps);
  Result<std::vector<Shown>> Walk(const simulator::CityOptions& city,
                                  const simulator::CarOptions& car,
                                  const std::vector<LightPreset>& lights, std::uint64_t stream) {
    return Counted(ShowWalks(plan_, workshop_, city, car, lights, stream));
  }
  Result<std::vector<Shown>> Counted(Result<std::vector<Shown>> shown) {
    if (shown) trials_.distinct_pictures += shown->size();
    return shown;
  }
  Result<void> AddTown();
  void AddMisstated(const MappedPlace* place, const std::vector<Shown>& walk);
  void AddDamaged(const MappedPlace* place, const std::vector<Shown>& walk);
  Result<void> AddRepeated(int kinds);
  void Add(Batch batch) {
    if (IsAsked(batch.kind)) trials_.batches.push_back(std::move(batch));
  }
  static std::vector<Shown> Misplaced(std::vector<Shown> pictures) {
    for (Shown& shown : pictures) shown.map_from_camera = Nowhere();
    return pictures;
  }

  const FalseAcceptsPlan& plan_;
  const Workshop& workshop_;
  FalseAcceptTrials trials_;
};

Result<const MappedPlace*> Preparation::MapPlace(const simulator::CityOptions& city,
                                                 const simulator::CarOptions& car,
                                                 const std::vector<LightPreset>& lights,
                                                 int submaps) {
  auto place = std::make_unique<MappedPlace>();
  std::vector<mapping::ReleasedSubmap> released;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const std::uint64_t seed = 1000 * plan_.seed + 100 + i;
    WAYMARK_TRY_ASSIGN(const auto views, PlanDrive(city, car, seed));
    WAYMARK_TRY_ASSIGN(const auto pictures, Draw({city, lights[i], seed}, views, workshop_));
    for (const View& view : views) {
      place->cameras_in_map.push_back(view.map_from_camera.translation());
    }
    const auto count = static_cast<std::size_t>(submaps);
    const std::size_t overlap = pictures.size() / count / 5;
    for (std::size_t s = 0; s < count; ++s) {
      const std::size_t begin = pictures.size() * s / count;
      const std::size_t end =
          std::min(pictures.size(), pictures.size() * (s + 1) / count + overlap);
      WAYMARK_TRY_ASSIGN(auto submap, BuildSubmap(std::span(pictures).subspan(begin, end - begin),
                                                  fmt::format("drive_{}_{}", i, s), workshop_));
      released.push_back(std::move(submap));
    }
  }
  WAYMARK_TRY_ASSIGN(const mapping::MapDirectory map, OpenWorkshopMap(workshop_));
  WAYMARK_TRY_ASSIGN(place->localiser,
                     localiser::Localiser::Create(map, ReleaseOf(std::move(released)), {}));
  trials_.places.push_back(std::move(place));
  return trials_.places.back().get();
}

void Preparation::AddDamaged(const MappedPlace* place, const std::vector<Shown>& walk) {
  for (const double sigma_px : {2.5, 6.0}) {
    Add({"out of focus", place,
         Damaged(walk, fmt::format("blur{}", sigma_px), [=](const mapping::GrayImage& image) {
           return BlurOutOfFocus(image, sigma_px);
         })});
  }
  for (const int length_px : {9, 21}) {
    Add({"blurred by motion", place,
         Damaged(walk, fmt::format("motion{}", length_px),
                 [=](const mapping::GrayImage& image) { return BlurByMotion(image, length_px); })});
  }
  for (const double share : {0.5, 0.75, 0.95}) {
    Add({"covered", place,
         Damaged(walk, fmt::format("cover{}", share), [=](const mapping::GrayImage& image) {
           const auto seed = static_cast<std::uint64_t>(100 * share) + Checksum(image.pixels);
           return Cover(image, share, Random(seed));
         })});
  }
  Add({"mirrored", place, Misplaced(Damaged(walk, "mirror", Mirror)), Claim::kInTheMap});
}

Result<void> Preparation::AddTown() {
  const std::vector<std::string> of_walks{"nothing wrong",   "no position stated",
                                          "position in another street",
                                          "focal length misstated", "out of focus",
                                          "blurred by motion", "covered", "mirrored"};
  const bool has_walks = IsAnyAsked(of_walks);
  if (!has_walks && !IsAnyAsked({"sky and eaves", "street that is not mapped", "another city",
                                 "real photographs"})) {
    return {};
  }
  WAYMARK_TRY_ASSIGN(const MappedPlace* town,
                     MapPlace(plan_.city, plan_.car, plan_.mapped, plan_.submaps_per_drive));
  if (has_walks) {
    WAYMARK_TRY_ASSIGN(const auto walk, Walk(plan_.city, plan_.car, plan_.asked, 1));
    AddMisstated(town, walk);
    AddDamaged(town, walk);
  }
  if (IsAsked("sky and eaves")) {
    WAYMARK_TRY_ASSIGN(auto sky, Counted(ShowSky(plan_, workshop_)));
    Add({"sky and eaves", town, std::move(sky), Claim::kTrue, 4});
  }
  const std::vector<LightPreset> lights{LightPreset::kDay, LightPreset::kNight};
  if (IsAsked("street that is not mapped")) {
    simulator::CarOptions around = plan_.car;  // walkers start where the map has ended
    around.drive.length_m = 2.4 * (plan_.city.block_east_m + plan_.city.block_north_m);
    WAYMARK_TRY_ASSIGN(auto unmapped, Walk(plan_.city, around, lights, 2));
    Add({"street that is not mapped", town, std::move(unmapped), Claim::kInTheMap, 3});
  }
  if (IsAsked("another city")) {
    simulator::CityOptions other = plan_.city;
    other.seed += 1;
    WAYMARK_TRY_ASSIGN(auto elsewhere, Walk(other, plan_.car, lights, 3));
    Add({"another city", town, Misplaced(std::move(elsewhere)), Claim::kInTheMap, 5});
  }
  if (plan_.photos.empty() || !IsAsked("real photographs")) return {};
  WAYMARK_TRY_ASSIGN(auto photos, Counted(ShowPhotos(plan_, workshop_)));
  Add({"real photographs", town, std::move(photos), Claim::kInTheMap, 3});
  return {};
}

void Preparation::AddMisstated(const MappedPlace* place, const std::vector<Shown>& walk) {
  Add({"nothing wrong", place, walk});
  Add({"no position stated", place, walk, Claim::kNone});
  Add({"position in another street", place, walk, Claim::kFarFromTruth, 2});
  if (!plan_.only.starts_with("focal")) return;    // a lie about the lens: only on request
  const std::array factors{0.7, 0.85, 1.15, 1.4};  // each picture meets two of them
  for (std::size_t f = 0; f < factors.size(); ++f) {
    std::vector<Shown> some;
    for (std::size_t i = f % 2; i < walk.size(); i += 2) some.push_back(walk[i]);
    Add({"focal length misstated", place, std::move(some), Claim::kTrue, 1, factors[f]});
  }
}

/// Streets whose houses are copies of one or two: inside the map, and copies beyond its end.
Result<void> Preparation::AddRepeated(int kinds) {
  simulator::CityOptions city = plan_.city;
  city.house_kinds = kinds;
  simulator::CarOptions car = plan_.car;
  car.drive.length_m = plan_.car.drive.length_m / 2;
  const std::string name = kinds == 1 ? "one kind of house" : "two kinds of houses";
  if (!IsAnyAsked({name + ", mapped", name + ", not mapped"})) return {};
  WAYMARK_TRY_ASSIGN(const MappedPlace* place, MapPlace(city, car, {LightPreset::kDay}, 2));
  const std::vector<LightPreset> lights{LightPreset::kDay, LightPreset::kNight};
  WAYMARK_TRY_ASSIGN(const auto inside, Walk(city, car, lights, 4));
  Add({name + ", mapped", place, inside, Claim::kTrue, 2});
  simulator::CarOptions beyond = car;
  beyond.drive.length_m += 2 * plan_.phone.walk.duration_s * plan_.phone.walk.speed_mps;
  WAYMARK_TRY_ASSIGN(const auto outside, Walk(city, beyond, lights, 5));
  Add({name + ", not mapped", place, outside, Claim::kTrue, 2});
  return {};
}

Result<FalseAcceptTrials> Preparation::Prepare() && {
  WAYMARK_TRY(AddTown());
  WAYMARK_TRY(AddRepeated(1));
  WAYMARK_TRY(AddRepeated(2));
  return std::move(trials_);
}

}  // namespace

void MakeQuick(FalseAcceptsPlan& plan) {
  UseTinyWorld(plan);
  plan.mapped = {LightPreset::kDay};
  plan.asked = {LightPreset::kDay};
  plan.submaps_per_drive = 1;
  plan.walkers = 1;
  plan.keyframes_per_walk = 3;
}

Result<FalseAcceptTrials> PrepareFalseAccepts(const FalseAcceptsPlan& plan,
                                              const Workshop& workshop) {
  return Preparation(plan, workshop).Prepare();
}

}  // namespace waymark::evaluation
