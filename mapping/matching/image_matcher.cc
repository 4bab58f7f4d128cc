// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/image_matcher.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "mapping/matching/internal/descriptor_cells.h"
#include "mapping/matching/internal/ratio_test.h"
#include "mapping/matching/internal/vocabulary.h"

namespace waymark::mapping {
namespace {

using Image = std::span<const Descriptor>;
using internal::CelledDescriptors;
using internal::DescriptorCells;

constexpr std::size_t kTrainingPerCell = 32;

/// The same number from each image, weak ones and strong ones.
std::vector<Descriptor> Sample(std::span<const Image> images, std::size_t count) {
  const std::size_t per_image = std::max<std::size_t>(1, count / images.size());
  std::vector<Descriptor> sample;
  for (const Image image : images) {
    const std::size_t taken = std::min(per_image, image.size());
    for (std::size_t i = 0; i < taken; ++i) sample.push_back(image[i * image.size() / taken]);
  }
  return sample;
}

std::size_t MeanSize(std::span<const Image> images) {
  std::size_t all = 0;
  for (const Image image : images) all += image.size();
  return all / images.size();
}

/// What the reverse search found, with the descriptor that asked first: in the cells that were
/// visited it may not have been.
NearestTwo WithAsker(NearestTwo nearest, std::uint32_t asker, std::int32_t dot) {
  if (nearest.first == asker || dot <= nearest.second_dot) return nearest;
  if (dot <= nearest.first_dot) {
    nearest.second_dot = dot;
    return nearest;
  }
  return {.first = asker, .first_dot = dot, .second_dot = nearest.first_dot};
}

}  // namespace

struct ImageMatcher::Cells {
  std::vector<CelledDescriptors> images;
};

Result<void> SearchOptions::Validate() const {
  if (exhaustive_below < 0 || cells < 16 || probes < 1 || probes > 16) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "search: expected exhaustive_below >= 0, cells >= 16, probes in [1, 16]; "
                     "found {}, {}, {}",
                     exhaustive_below, cells, probes);
  }
  return {};
}

ImageMatcher::ImageMatcher(std::vector<Image> images, const MatchOptions& matching,
                           const SearchOptions& search, const Parallelism& parallelism)
    : images_(std::move(images)), matching_(matching) {
  if (images_.empty() || MeanSize(images_) < static_cast<std::size_t>(search.exhaustive_below)) {
    return;
  }
  const auto cell_count = static_cast<std::size_t>(search.cells);
  std::vector<Descriptor> centres = internal::TrainVocabulary(
      Sample(images_, kTrainingPerCell * cell_count), cell_count, search.seed);
  if (centres.empty()) return;
  const DescriptorCells cells(std::move(centres));
  auto sorted = std::make_unique<Cells>();
  sorted->images.resize(images_.size());
  ParallelFor(images_.size(), parallelism, [&](std::size_t i) {
    sorted->images[i] = cells.Sort(images_[i], static_cast<std::size_t>(search.probes));
  });
  cells_ = std::move(sorted);
}

ImageMatcher::~ImageMatcher() = default;
ImageMatcher::ImageMatcher(ImageMatcher&&) noexcept = default;

std::vector<FeatureMatch> ImageMatcher::Match(const ImagePair& pair) const {
  const Image first = images_[pair.first];
  const Image second = images_[pair.second];
  if (!cells_) return MatchDescriptors(first, second, matching_);
  const CelledDescriptors& first_cells = cells_->images[pair.first];
  const CelledDescriptors& second_cells = cells_->images[pair.second];
  std::vector<std::uint32_t> all(first.size());
  std::iota(all.begin(), all.end(), 0U);
  const std::vector<NearestTwo> there =
      DescriptorCells::FindNearestTwo(first, first_cells, all, second, second_cells);
  std::vector<FeatureMatch> matches;
  std::vector<std::uint32_t> chosen;
  for (const std::uint32_t i : all) {
    const auto choice = internal::Choose(there[i], matching_);
    if (!choice) continue;
    matches.push_back({.first = i, .second = *choice});
    chosen.push_back(*choice);
  }
  if (!matching_.mutual) return matches;
  const std::vector<NearestTwo> back =
      DescriptorCells::FindNearestTwo(second, second_cells, chosen, first, first_cells);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::uint32_t asker = matches[i].first;
    const NearestTwo nearest = WithAsker(back[i], asker, there[asker].first_dot);
    if (internal::Choose(nearest, matching_) == asker) matches[kept++] = matches[i];
  }
  matches.resize(kept);
  return matches;
}

}  // namespace waymark::mapping
