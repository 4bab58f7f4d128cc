// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/planning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "mapping/pipeline/internal/membership.h"
#include "mapping/pipeline/internal/options_codec.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

double RoundTo(double value, double step) { return std::round(value / step) * step; }

/// About a decimetre: a submap's origin is a name for its frame, not a measurement.
GeoPoint Rounded(const GeoPoint& place) {
  return {Angle::Degrees(RoundTo(place.latitude.degrees(), 1e-6)),
          Angle::Degrees(RoundTo(place.longitude.degrees(), 1e-6)),
          RoundTo(place.ellipsoid_height_m, 0.1)};
}

std::optional<Point<Map>> PositionOf(const IndexedImage& image, const MapDirectory& map,
                                     const TangentPlane& plane) {
  if (!image.gnss || !map.description().is_geo_aligned) return std::nullopt;
  return plane.ToMap(*image.gnss);
}

/// Images of other experiences, flat, with their indexes.
struct Neighbourhood {
  std::vector<ExperienceIndex> experiences;
  std::vector<ForeignImage> images;
  std::vector<const IndexedImage*> indexed;  ///< of each of `images`
};

/// Names of the images of an experience whose submaps were removed from the map.
Result<std::set<std::string>> ListWithdrawn(const MapDirectory& map, const ExperienceId& id,
                                            const std::set<SubmapId>& in_map,
                                            std::optional<std::set<SubmapId>>& released) {
  std::set<std::string> withdrawn;
  const fs::path folder = map.ExperienceFolder(id);
  WAYMARK_TRY_ASSIGN(const std::optional<Plan> plan, LoadPlan(folder));
  if (!plan) return withdrawn;
  for (const std::string& name : plan->tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, name));
    if (!decision || !decision->submap || in_map.contains(*decision->submap)) continue;
    if (!released) {
      WAYMARK_TRY_ASSIGN(released, LoadReleasedSubmaps(map));  // rarely needed, and not cheap
    }
    if (!released->contains(*decision->submap)) continue;  // it is yet to be released
    WAYMARK_TRY_ASSIGN(const SubmapTask task, LoadTask(folder, name));
    for (const TaskImage& image : task.images) {
      if (!image.is_borrowed) withdrawn.insert(image.name);
    }
  }
  return withdrawn;
}

Result<Neighbourhood> LoadNeighbourhood(const MapDirectory& map, const TangentPlane& plane,
                                        const ExperienceId& except,
                                        const std::set<SubmapId>& in_map) {
  Neighbourhood found;
  std::optional<std::set<SubmapId>> released;
  WAYMARK_TRY_ASSIGN(const std::vector<ExperienceId> planned, ListPlannedExperiences(map));
  for (const ExperienceId& id : planned) {
    if (id == except) continue;
    WAYMARK_TRY_ASSIGN(ExperienceIndex index, LoadIndex(map.ExperienceFolder(id)));
    WAYMARK_TRY_ASSIGN(const auto withdrawn, ListWithdrawn(map, id, in_map, released));
    std::erase_if(index.images,
                  [&](const IndexedImage& image) { return withdrawn.contains(image.name); });
    found.experiences.push_back(std::move(index));
  }
  for (std::size_t e = 0; e < found.experiences.size(); ++e) {
    for (const IndexedImage& image : found.experiences[e].images) {
      found.images.push_back({static_cast<std::uint32_t>(e), PositionOf(image, map, plane)});
      found.indexed.push_back(&image);
    }
  }
  return found;
}

GeoPoint ChooseOrigin(const MapDirectory& map, const TangentPlane& plane, const ImageSubset& subset,
                      std::span<const SplitImage> images) {
  if (!subset.centre) return map.description().origin;
  double height_m = 0;
  int count = 0;
  for (const std::uint32_t i : subset.owned) {
    if (!images[i].position) continue;
    height_m += images[i].position->coordinates().z();
    ++count;
  }
  const Eigen::Vector3d& centre = subset.centre->coordinates();
  return Rounded(plane.ToGeo(Point<Map>(centre.x(), centre.y(), count > 0 ? height_m / count : 0)));
}

SubmapTask MakeTask(const ExperienceIndex& index, const ImageSubset& subset,
                    const Neighbourhood& neighbourhood, const GeoPoint& origin,
                    const PipelineOptions& options) {
  SubmapTask task{.experience = index.id,
                  .origin = origin,
                  .options = options,
                  .contents = {{index.id, index.content}}};
  std::vector<std::pair<std::uint32_t, bool>> own;
  for (const std::uint32_t i : subset.owned) own.emplace_back(i, false);
  for (const std::uint32_t i : subset.neighbour) own.emplace_back(i, true);
  std::sort(own.begin(), own.end());
  for (const auto& [i, is_borrowed] : own) {
    task.images.push_back({index.id, index.images[i].name, is_borrowed});
  }
  for (const std::uint32_t i : subset.foreign) {
    const ExperienceIndex& lender = neighbourhood.experiences[neighbourhood.images[i].experience];
    task.contents.emplace(lender.id, lender.content);
    task.images.push_back({lender.id, neighbourhood.indexed[i]->name, true});
  }
  return task;
}

/// Whether every task that is not built yet still finds all that it borrows.
Result<bool> IsBuildable(const MapDirectory& map, const fs::path& folder, const Plan& plan) {
  for (const std::string& name : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const std::optional<Decision> decision, LoadDecision(folder, name));
    if (decision) continue;
    WAYMARK_TRY_ASSIGN(const SubmapTask task, LoadTask(folder, name));
    for (const auto& [experience, content] : task.contents) {
      const auto lender = LoadIndex(map.ExperienceFolder(experience));
      if (!lender && lender.error().code != ErrorCode::kNotFound) return lender.error();
      if (!lender || lender->content != content) return false;
    }
  }
  return true;
}

}  // namespace

Result<SubmapTask> LoadTask(const fs::path& experience_folder, const std::string& task) {
  const fs::path path = TaskPath(experience_folder, task);
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  return DecodeTask(text, path.string());
}

Result<std::optional<Plan>> LoadPlan(const fs::path& experience_folder) {
  const fs::path path = PlanPath(experience_folder);
  const auto text = LoadTextFile(path);
  if (!text && text.error().code == ErrorCode::kNotFound) return std::optional<Plan>();
  if (!text) return text.error();
  WAYMARK_TRY_ASSIGN(Plan plan, DecodePlan(*text, path.string()));
  return std::optional<Plan>(std::move(plan));
}

Result<std::optional<Decision>> LoadDecision(const fs::path& experience_folder,
                                             const std::string& task) {
  const fs::path path = DecisionPath(experience_folder, task);
  const auto text = LoadTextFile(path);
  if (!text && text.error().code == ErrorCode::kNotFound) return std::optional<Decision>();
  if (!text) return text.error();
  WAYMARK_TRY_ASSIGN(Decision decision, DecodeDecision(*text, path.string()));
  return std::optional<Decision>(std::move(decision));
}

Result<std::vector<ExperienceId>> ListPlannedExperiences(const MapDirectory& map) {
  WAYMARK_TRY_ASSIGN(std::vector<ExperienceId> ids, map.ListExperiences());
  std::erase_if(ids, [&](const ExperienceId& id) {
    std::error_code ignored;
    return !fs::exists(PlanPath(map.ExperienceFolder(id)), ignored);
  });
  return ids;
}

Result<Plan> PlanExperience(const MapDirectory& map, const ExperienceIndex& index,
                            const std::set<SubmapId>& in_map, const PipelineOptions& options) {
  const fs::path folder = map.ExperienceFolder(index.id);
  const std::string options_hash =
      ContentHash(std::string_view(index.content + EncodeBuildOptions(options)));
  WAYMARK_TRY_ASSIGN(std::optional<Plan> existing, LoadPlan(folder));
  if (existing && existing->options == options_hash) {
    WAYMARK_TRY_ASSIGN(const bool is_buildable, IsBuildable(map, folder, *existing));
    if (is_buildable) return *std::move(existing);
  }

  const TangentPlane plane(map.description().origin);
  WAYMARK_TRY_ASSIGN(const Neighbourhood neighbourhood,
                     LoadNeighbourhood(map, plane, index.id, in_map));
  std::vector<SplitImage> images;
  for (const IndexedImage& image : index.images) {
    images.push_back({image.time, PositionOf(image, map, plane)});
  }
  WAYMARK_TRY_ASSIGN(const Split split,
                     SplitExperience(images, neighbourhood.images, options.split));

  Plan plan{.options = options_hash};
  for (const std::uint32_t i : split.thinned_out) plan.thinned_out.push_back(index.images[i].name);
  WAYMARK_TRY(CreateFolders(folder / "tasks"));
  for (const ImageSubset& subset : split.subsets) {
    const std::string task = EncodeTask(
        MakeTask(index, subset, neighbourhood, ChooseOrigin(map, plane, subset, images), options));
    plan.tasks.push_back(ContentHash(std::string_view(task)));
    WAYMARK_TRY(StoreFileAtomically(TaskPath(folder, plan.tasks.back()), std::string_view(task)));
  }
  WAYMARK_TRY(StoreFileAtomically(PlanPath(folder), std::string_view(EncodePlan(plan))));
  return plan;
}

}  // namespace waymark::mapping
