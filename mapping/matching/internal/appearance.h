// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/features/features.h"

namespace waymark::mapping::internal {

struct AppearanceOptions {
  std::size_t features_per_image = 1500;  ///< strongest used
  std::size_t words_per_image = 60;
  std::size_t max_words = 8192;
  std::size_t training_per_word = 10;
  std::uint32_t seed = 1;
  Parallelism parallelism;
};

/// How much images look alike, by the visual words they share. The vocabulary is trained on the
/// images themselves. Immutable, thread-safe.
/// Source: Sivic & Zisserman, "Video Google", ICCV 2003 (tf-idf).
class AppearanceIndex {
 public:
  /// Shapes: descriptors of each image, strongest first.
  AppearanceIndex(std::span<const std::span<const Descriptor>> images,
                  const AppearanceOptions& options);

  /// The similarity of one image to each image, 0 (no word in common) to 1 (the same words).
  std::vector<float> Similarities(std::size_t image) const;

 private:
  struct Entry {
    std::uint32_t key;  ///< a word in a list of words, an image in a list of images
    float weight;
  };

  std::vector<std::vector<Entry>> words_of_image_;
  std::vector<std::vector<Entry>> images_of_word_;
};

}  // namespace waymark::mapping::internal
