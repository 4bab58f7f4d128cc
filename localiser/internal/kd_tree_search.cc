// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/kd_tree_search.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>

#include <flann/flann.hpp>

#include "mapping/base/check.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {
namespace {

using mapping::Descriptor;
using mapping::DescriptorAngle;

constexpr std::size_t kNeighbours = 16;  // a landmark has two descriptors
constexpr std::size_t kDimensions = std::tuple_size_v<Descriptor>;

// FLANN's interface takes pointers to what it only reads.
flann::Matrix<unsigned char> Rows(std::span<const Descriptor> descriptors) {
  auto* const bytes = const_cast<unsigned char*>(descriptors.front().data());
  return {bytes, descriptors.size(), kDimensions};
}

std::int32_t Dot(const Descriptor& a, const Descriptor& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), std::int32_t{0});
}

}  // namespace

struct KdTreeSearch::Trees {
  flann::Index<flann::L2<unsigned char>> index;
  flann::SearchParams search;
};

KdTreeSearch::KdTreeSearch(std::span<const Descriptor> descriptors,
                           std::span<const std::uint32_t> landmarks,
                           const LandmarkSearchOptions& options, const KdTreeOptions& trees)
    : options_(options),
      descriptors_(descriptors.begin(), descriptors.end()),
      landmarks_(landmarks.begin(), landmarks.end()) {
  CHECK(descriptors.size() == landmarks.size());
  if (descriptors_.empty()) return;
  auto made = std::make_unique<Trees>(
      Trees{{Rows(descriptors_), flann::KDTreeIndexParams(trees.trees)},
            flann::SearchParams(trees.checks < 0 ? flann::FLANN_CHECKS_UNLIMITED : trees.checks)});
  made->index.buildIndex();
  trees_ = std::move(made);
}

KdTreeSearch::KdTreeSearch(KdTreeSearch&&) noexcept = default;
KdTreeSearch::~KdTreeSearch() = default;

std::size_t KdTreeSearch::bytes() const {
  const auto trees = trees_ ? static_cast<std::size_t>(trees_->index.usedMemory()) : 0;
  return std::span(descriptors_).size_bytes() + std::span(landmarks_).size_bytes() + trees;
}

FoundLandmarks KdTreeSearch::Match(std::span<const Descriptor> features) const {
  FoundLandmarks found;
  if (!trees_ || features.empty()) return found;
  const std::size_t count = std::min(kNeighbours, descriptors_.size());
  std::vector<std::size_t> indices(features.size() * count);
  std::vector<float> distances(features.size() * count);
  flann::Matrix<std::size_t> index_rows(indices.data(), features.size(), count);
  flann::Matrix<float> distance_rows(distances.data(), features.size(), count);
  trees_->index.knnSearch(Rows(features), index_rows, distance_rows, count, trees_->search);
  std::vector<Resemblance> alike;  // the best of each landmark
  for (std::uint32_t f = 0; f < features.size(); ++f) {
    alike.clear();
    for (const std::size_t index : std::span(indices).subspan(f * count, count)) {
      if (index >= descriptors_.size()) continue;  // fewer were found
      const std::uint32_t landmark = landmarks_[index];
      const bool is_known =
          std::ranges::any_of(alike, [&](const auto& a) { return a.landmark == landmark; });
      if (!is_known) alike.push_back({f, landmark, Dot(features[f], descriptors_[index])});
    }
    if (alike.empty()) continue;
    std::ranges::sort(alike, [](const Resemblance& a, const Resemblance& b) {
      return std::tie(b.dot, a.landmark) < std::tie(a.dot, b.landmark);
    });
    const double angle_rad = DescriptorAngle(alike[0].dot);
    const double other_rad = DescriptorAngle(alike.size() > 1 ? alike[1].dot : 0);
    const double ratio = other_rad > 0 ? angle_rad / other_rad : 1;
    if (angle_rad <= options_.max_angle_rad && ratio < options_.max_ratio) {
      found.matches.push_back({f, alike[0].landmark, static_cast<float>(ratio)});
    }
    alike.resize(std::min(alike.size(), options_.max_resemblances), alike[0]);
    std::ranges::copy_if(alike, std::back_inserter(found.resemblances), [&](const auto& a) {
      return DescriptorAngle(a.dot) <= options_.max_resemblance_rad;
    });
  }
  return found;
}

}  // namespace waymark::localiser::internal
