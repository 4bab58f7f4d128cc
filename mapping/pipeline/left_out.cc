// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/left_out.h"

#include <algorithm>
#include <set>

#include "mapping/io/submap_file.h"
#include "mapping/pipeline/internal/planning.h"

namespace waymark::mapping {

Result<std::vector<LeftOutImage>> ListLeftOut(const MapDirectory& map, const ExperienceIndex& index,
                                              const Plan& plan) {
  std::vector<LeftOutImage> left_out;
  for (const UnusableImage& image : index.unusable) {
    left_out.push_back({index.id, image.name, image.reason});
  }
  for (const std::string& name : plan.thinned_out) {
    left_out.push_back({index.id, name, "its place has more images than one submap takes"});
  }
  std::set<std::string> held;
  std::vector<LeftOutImage> candidates;
  for (const std::string& task : plan.tasks) {
    WAYMARK_TRY_ASSIGN(const auto decision, LoadDecision(map.ExperienceFolder(index.id), task));
    if (!decision) continue;
    candidates.insert(candidates.end(), decision->left_out.begin(), decision->left_out.end());
    if (!decision->submap) continue;
    WAYMARK_TRY_ASSIGN(const SubmapView view, SubmapView::Open(map.SubmapPath(*decision->submap),
                                                               SubmapReading::kImagesOnly));
    for (const SubmapImage& image : view.images()) {
      if (image.experience == index.id) held.insert(image.name);
    }
  }
  std::erase_if(candidates, [&](const LeftOutImage& image) { return held.contains(image.name); });
  left_out.insert(left_out.end(), candidates.begin(), candidates.end());
  std::stable_sort(left_out.begin(), left_out.end(),
                   [](const auto& a, const auto& b) { return a.name < b.name; });
  return left_out;
}

}  // namespace waymark::mapping
