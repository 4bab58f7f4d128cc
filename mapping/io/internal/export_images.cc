// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/internal/export_images.h"

#include <map>
#include <set>
#include <utility>

namespace waymark::mapping::internal {
namespace {

using ImageKey = std::pair<ExperienceId, std::string>;

struct Choice {
  std::size_t submap;
  std::uint32_t image;
};

ImageKey KeyOf(const SubmapImage& image) { return {image.experience, image.name}; }

/// Which submap shows each image.
std::map<ImageKey, Choice> ChooseSubmaps(std::span<const ExportSubmap> submaps) {
  std::map<ImageKey, Choice> choices;
  for (std::size_t s = 0; s < submaps.size(); ++s) {
    const auto images = submaps[s].images();
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      const auto [entry, is_new] = choices.emplace(KeyOf(images[i]), Choice{s, i});
      const Choice& held = entry->second;
      const bool is_better =
          submaps[held.submap].images()[held.image].is_borrowed && !images[i].is_borrowed;
      if (!is_new && is_better) entry->second = {s, i};
    }
  }
  return choices;
}

}  // namespace

ExportedImages MergeImages(std::span<const ExportSubmap> submaps) {
  const auto choices = ChooseSubmaps(submaps);
  std::set<ExperienceId> experiences;
  for (const auto& [key, choice] : choices) experiences.insert(key.first);
  ExportedImages merged;
  std::map<ImageKey, std::uint32_t> places;
  for (const auto& [key, choice] : choices) {
    const auto& [experience, name] = key;
    const SubmapImage& image = submaps[choice.submap].images()[choice.image];
    places.emplace(key, static_cast<std::uint32_t>(merged.images.size()));
    merged.images.push_back(
        {experiences.size() > 1 ? experience.text() + "/" + name : name, choice.submap,
         choice.image,
         CarryPose(submaps[choice.submap].map_from_submap(), image.submap_from_camera)});
  }
  for (const ExportSubmap& submap : submaps) {
    auto& row = merged.places.emplace_back();
    for (const SubmapImage& image : submap.images()) row.push_back(places.at(KeyOf(image)));
  }
  return merged;
}

Result<void> CheckNamesHaveNoBlanks(const ExportedImages& merged, std::string_view format) {
  for (const ExportedImage& image : merged.images) {
    if (image.name.find(' ') == std::string::npos) continue;
    return MakeError(ErrorCode::kUnsupported,
                     "{}: expected image names without blanks, at which it separates, found \"{}\"",
                     format, image.name);
  }
  return {};
}

}  // namespace waymark::mapping::internal
