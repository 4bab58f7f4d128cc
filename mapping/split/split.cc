// SPDX-License-Identifier: Apache-2.0
#include "mapping/split/split.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "mapping/split/internal/cores.h"
#include "mapping/split/internal/outliers.h"
#include "mapping/split/internal/sampling.h"

namespace waymark::mapping {
namespace {

Eigen::Vector2d Horizontal(const Point<Map>& position) { return position.coordinates().head<2>(); }

std::size_t ShareOf(double share, int count) {
  return static_cast<std::size_t>(std::floor(share * count));
}

/// At most `limit` of the candidates, taking turns between experiences so that each is joined.
std::vector<std::uint32_t> SampleForeign(std::span<const ForeignImage> foreign,
                                         std::span<const std::uint32_t> candidates,
                                         std::size_t limit, std::mt19937_64& random) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> by_experience;
  for (const std::uint32_t i : candidates) by_experience[foreign[i].experience].push_back(i);
  std::vector<std::uint32_t> chosen;
  std::size_t experiences_left = by_experience.size();
  // Those with few candidates first: what they leave over goes to the others.
  std::vector<std::vector<std::uint32_t>> groups;
  for (auto& [experience, group] : by_experience) groups.push_back(std::move(group));
  std::stable_sort(groups.begin(), groups.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  for (auto& group : groups) {
    const std::size_t fair = (limit - chosen.size()) / experiences_left--;
    const std::vector<std::uint32_t> sample = SampleValues(std::move(group), fair, random);
    chosen.insert(chosen.end(), sample.begin(), sample.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// A subset before its images are limited to what it may hold.
struct Draft {
  ImageSubset subset;
  std::vector<std::uint32_t> foreign_candidates;
};

/// Limits a draft's own images, leaving room for those it will borrow.
void ThinOut(std::size_t borrowable, const SplitOptions& options, std::mt19937_64& random,
             Draft& draft, std::vector<std::uint32_t>& thinned_out) {
  const std::size_t reserved =
      std::min(borrowable, ShareOf(options.neighbour_share, options.max_images)) +
      std::min(draft.foreign_candidates.size(), ShareOf(options.foreign_share, options.max_images));
  const std::size_t room = static_cast<std::size_t>(options.max_images) - reserved;
  std::vector<std::uint32_t> kept = SampleValues(draft.subset.owned, room, random);
  std::set_difference(draft.subset.owned.begin(), draft.subset.owned.end(), kept.begin(),
                      kept.end(), std::back_inserter(thinned_out));
  draft.subset.owned = std::move(kept);
}

/// Adds borrowed images. `borrowable` are images kept by other subsets that lie in this circle.
void Borrow(std::vector<std::uint32_t> borrowable, std::span<const ForeignImage> foreign,
            const SplitOptions& options, std::mt19937_64& random, Draft& draft) {
  ImageSubset& subset = draft.subset;
  const std::size_t limit = static_cast<std::size_t>(options.max_images);
  subset.neighbour = SampleValues(
      std::move(borrowable),
      std::min(ShareOf(options.neighbour_share, options.max_images), limit - subset.owned.size()),
      random);
  const std::size_t own = subset.owned.size() + subset.neighbour.size();
  // Never more than its own images, so that a place with many experiences costs at most double.
  const std::size_t foreign_limit =
      std::min({ShareOf(options.foreign_share, options.max_images), limit - own, own});
  subset.foreign = SampleForeign(foreign, draft.foreign_candidates, foreign_limit, random);
}

std::vector<std::uint32_t> ForeignInside(std::span<const ForeignImage> foreign,
                                         const Circle& circle) {
  std::vector<std::uint32_t> inside;
  for (std::uint32_t i = 0; i < foreign.size(); ++i) {
    if (foreign[i].position && circle.Contains(Horizontal(*foreign[i].position))) {
      inside.push_back(i);
    }
  }
  return inside;
}

/// Which draft owns each image; nothing for thinned-out ones.
std::vector<std::optional<std::size_t>> FindOwners(const std::vector<Draft>& drafts,
                                                   std::size_t image_count) {
  std::vector<std::optional<std::size_t>> owners(image_count);
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    for (const std::uint32_t image : drafts[i].subset.owned) owners[image] = i;
  }
  return owners;
}

/// Images without a position go where the image nearest in time is.
void AssignUnplaced(std::span<const SplitImage> images, std::vector<Draft>& drafts) {
  const auto owners = FindOwners(drafts, images.size());
  std::vector<std::pair<SensorTime, std::size_t>> placed;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (owners[i]) placed.emplace_back(images[i].time, *owners[i]);
  }
  std::sort(placed.begin(), placed.end());
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    if (owners[i]) continue;
    auto next =
        std::lower_bound(placed.begin(), placed.end(), std::pair(images[i].time, std::size_t{0}));
    if (next == placed.end() || (next != placed.begin() && images[i].time - std::prev(next)->first <
                                                               next->first - images[i].time)) {
      --next;
    }
    drafts[next->second].subset.owned.push_back(i);
  }
  for (Draft& draft : drafts) std::sort(draft.subset.owned.begin(), draft.subset.owned.end());
}

Split SplitByPosition(std::span<const SplitImage> images, std::span<const ForeignImage> foreign,
                      const SplitOptions& options) {
  std::vector<Eigen::Vector2d> positions;
  std::vector<std::uint32_t> image_of_position;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    if (!images[i].position) continue;
    positions.push_back(Horizontal(*images[i].position));
    image_of_position.push_back(i);
  }
  std::vector<Draft> drafts;
  std::vector<Circle> circles;
  for (const Core& core : SweepCores(positions, options)) {
    Draft draft;
    circles.push_back(SharingCircle(positions, core, options));
    const Circle& circle = circles.back();
    draft.subset.centre = Point<Map>(circle.centre.x(), circle.centre.y(), 0);
    draft.subset.radius_m = circle.radius;
    for (const std::uint32_t i : core.images) draft.subset.owned.push_back(image_of_position[i]);
    draft.foreign_candidates = ForeignInside(foreign, circle);
    drafts.push_back(std::move(draft));
  }
  AssignUnplaced(images, drafts);

  const auto borrowable = [&](const std::vector<std::optional<std::size_t>>& owners,
                              std::size_t subset) {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t i : image_of_position) {
      if (owners[i] && *owners[i] != subset &&
          circles[subset].Contains(Horizontal(*images[i].position))) {
        found.push_back(i);
      }
    }
    return found;
  };
  Split split;
  const auto owners = FindOwners(drafts, images.size());
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    std::mt19937_64 random = SubsetRandom(options.seed, 2 * i);
    ThinOut(borrowable(owners, i).size(), options, random, drafts[i], split.thinned_out);
  }
  const auto keepers = FindOwners(drafts, images.size());
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    std::mt19937_64 random = SubsetRandom(options.seed, 2 * i + 1);
    Borrow(borrowable(keepers, i), foreign, options, random, drafts[i]);
  }
  for (Draft& draft : drafts) split.subsets.push_back(std::move(draft.subset));
  std::sort(split.thinned_out.begin(), split.thinned_out.end());
  return split;
}

/// Without positions: equal windows of the sequence that share images at their ends.
Split SplitBySequence(std::span<const SplitImage> images, std::span<const ForeignImage> foreign,
                      const SplitOptions& options) {
  std::vector<std::uint32_t> order(images.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return images[a].time < images[b].time;
  });
  std::vector<std::uint32_t> foreign_candidates;
  for (std::uint32_t i = 0; i < foreign.size(); ++i) {
    if (!foreign[i].position) foreign_candidates.push_back(i);
  }
  const std::size_t limit = static_cast<std::size_t>(options.max_images);
  const std::size_t margin =
      images.size() <= limit
          ? 0
          : std::max<std::size_t>(1, ShareOf(options.neighbour_share, options.max_images) / 2);
  const std::size_t window = limit - 2 * margin;
  const std::size_t count = (images.size() + window - 1) / window;

  Split split;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = i * order.size() / count;
    const std::size_t end = (i + 1) * order.size() / count;
    Draft draft;
    draft.subset.owned.assign(order.begin() + begin, order.begin() + end);
    std::sort(draft.subset.owned.begin(), draft.subset.owned.end());
    draft.foreign_candidates = foreign_candidates;
    std::vector<std::uint32_t> near(order.begin() + (begin - std::min(begin, margin)),
                                    order.begin() + begin);
    near.insert(near.end(), order.begin() + end,
                order.begin() + std::min(end + margin, order.size()));
    std::mt19937_64 random = SubsetRandom(options.seed, i);
    Borrow(std::move(near), foreign, options, random, draft);
    split.subsets.push_back(std::move(draft.subset));
  }
  return split;
}

}  // namespace

Result<Split> SplitExperience(std::span<const SplitImage> images,
                              std::span<const ForeignImage> foreign, const SplitOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (images.empty()) {
    return MakeError(ErrorCode::kInvalidArgument, "nothing to split: the experience has no images");
  }
  const std::vector<SplitImage> plausible = WithoutOutliers(images);
  const auto placed = std::ranges::count_if(
      plausible, [](const SplitImage& image) { return image.position.has_value(); });
  return placed < 3 ? SplitBySequence(plausible, foreign, options)
                    : SplitByPosition(plausible, foreign, options);
}

}  // namespace waymark::mapping
