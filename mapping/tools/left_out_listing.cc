// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/left_out_listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace waymark::mapping {

void PrintLeftOut(std::span<const LeftOutImage> images) {
  constexpr std::size_t kNamesShown = 30;
  if (images.empty()) return;
  std::map<std::pair<ExperienceId, std::string>, std::vector<std::string>> names_by_reason;
  for (const LeftOutImage& image : images) {
    names_by_reason[{image.experience, image.reason}].push_back(image.name);
  }
  fmt::print("left out: {} images\n", images.size());
  for (const auto& [key, names] : names_by_reason) {
    const std::size_t shown = std::min(kNamesShown, names.size());
    fmt::print("  {}: {}: {}", key.first.text(), key.second,
               fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
    if (shown < names.size()) fmt::print(" and {} more", names.size() - shown);
    fmt::print("\n");
  }
}

}  // namespace waymark::mapping
