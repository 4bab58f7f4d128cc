// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/appearance.h"

#include <algorithm>
#include <cmath>

#include "mapping/matching/descriptor_matching.h"
#include "mapping/matching/internal/vocabulary.h"

namespace waymark::mapping::internal {
namespace {

using Image = std::span<const Descriptor>;

Image Strongest(Image image, std::size_t count) {
  return image.first(std::min(image.size(), count));
}

/// The same number from each image, so that no experience dominates the words.
std::vector<Descriptor> Sample(std::span<const Image> images, std::size_t words,
                               const AppearanceOptions& options) {
  const std::size_t per_image = std::clamp<std::size_t>(
      options.training_per_word * words / images.size(), 1, options.features_per_image);
  std::vector<Descriptor> sample;
  for (const Image image : images) {
    const Image strongest = Strongest(image, per_image);
    sample.insert(sample.end(), strongest.begin(), strongest.end());
  }
  return sample;
}

}  // namespace

AppearanceIndex::AppearanceIndex(std::span<const Image> images, const AppearanceOptions& options)
    : words_of_image_(images.size()) {
  if (images.empty()) return;
  const std::size_t wanted = std::min(options.max_words, options.words_per_image * images.size());
  const std::vector<Descriptor> words =
      TrainVocabulary(Sample(images, wanted, options), wanted, options.seed);
  ParallelFor(images.size(), options.parallelism, [&](std::size_t i) {
    std::vector<float> counts(words.size());
    for (const NearestTwo& nearest :
         FindNearestTwo(Strongest(images[i], options.features_per_image), words)) {
      if (nearest.first < words.size()) counts[nearest.first] += 1;
    }
    for (std::uint32_t word = 0; word < counts.size(); ++word) {
      // The square root keeps repeated structure (facades, fences) from outweighing the rest.
      if (counts[word] > 0) words_of_image_[i].push_back({word, std::sqrt(counts[word])});
    }
  });
  std::vector<std::size_t> images_with_word(words.size());
  for (const auto& entries : words_of_image_) {
    for (const Entry& entry : entries) ++images_with_word[entry.key];
  }
  images_of_word_.resize(words.size());
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    double squared = 0;
    for (Entry& entry : words_of_image_[i]) {
      entry.weight *= std::log(static_cast<float>(images.size() + 1) /
                               static_cast<float>(images_with_word[entry.key]));
      squared += static_cast<double>(entry.weight) * entry.weight;
    }
    for (Entry& entry : words_of_image_[i]) {
      entry.weight /= static_cast<float>(std::sqrt(squared));
      images_of_word_[entry.key].push_back({i, entry.weight});
    }
  }
}

std::vector<float> AppearanceIndex::Similarities(std::size_t image) const {
  std::vector<float> similarities(words_of_image_.size());
  for (const Entry& word : words_of_image_[image]) {
    for (const Entry& other : images_of_word_[word.key]) {
      similarities[other.key] += word.weight * other.weight;
    }
  }
  return similarities;
}

}  // namespace waymark::mapping::internal
