// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/candidate_pairs.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "mapping/matching/internal/appearance.h"

namespace waymark::mapping {
namespace {

using Images = std::span<const PairingImage>;

/// Powers of two reach this many times as far as the plain successors.
constexpr std::size_t kSparseReach = 8;

/// Appearance may find what GNSS places wrongly, but not this many radii away.
constexpr double kRetrievalRadii = 5;

class PairSet {
 public:
  explicit PairSet(std::size_t image_count) : partners_(image_count) {}

  bool Contains(std::uint32_t a, std::uint32_t b) const { return partners_[a].contains(b); }

  void Add(std::uint32_t a, std::uint32_t b) {
    partners_[a].insert(b);
    partners_[b].insert(a);
  }

  std::vector<ImagePair> Sorted() const {
    std::vector<ImagePair> pairs;
    for (std::uint32_t a = 0; a < partners_.size(); ++a) {
      for (const std::uint32_t b : partners_[a]) {
        if (a < b) pairs.push_back({.first = a, .second = b});
      }
    }
    return pairs;
  }

 private:
  std::vector<std::set<std::uint32_t>> partners_;
};

/// Between the GNSS positions, on the ground: heights are the poorest of GNSS.
std::optional<double> Distance_m(const PairingImage& a, const PairingImage& b) {
  if (!a.gnss_in_map || !b.gnss_in_map) return std::nullopt;
  return (a.gnss_in_map->coordinates() - b.gnss_in_map->coordinates()).head<2>().norm();
}

void AddSequential(Images images, const PairingOptions& options, PairSet& pairs) {
  std::map<std::string, std::vector<std::uint32_t>> sequences;
  for (std::uint32_t i = 0; i < images.size(); ++i) sequences[images[i].sequence].push_back(i);
  const auto neighbours = static_cast<std::size_t>(options.sequential_neighbours);
  for (auto& [name, sequence] : sequences) {
    std::ranges::stable_sort(sequence, {}, [&](std::uint32_t i) { return images[i].time; });
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const auto add = [&](std::size_t step) {
        if (i + step < sequence.size()) pairs.Add(sequence[i], sequence[i + step]);
      };
      for (std::size_t step = 1; step <= neighbours; ++step) add(step);
      for (std::size_t step = 1; step <= kSparseReach * neighbours; step *= 2) add(step);
    }
  }
}

/// The `count` best of the candidates that are not yet paired with `image`; (cost, index) ordered.
void AddBest(std::uint32_t image, std::vector<std::pair<double, std::uint32_t>> candidates,
             int count, PairSet& pairs) {
  const std::size_t kept = std::min(candidates.size(), static_cast<std::size_t>(count));
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(kept),
                    candidates.end());
  for (std::size_t i = 0; i < kept; ++i) pairs.Add(image, candidates[i].second);
}

/// Those that the sequence gives already do not count: other passes and cameras get their turn.
void AddSpatial(Images images, const PairingOptions& options, PairSet& pairs) {
  const PairSet given = pairs;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    std::vector<std::pair<double, std::uint32_t>> candidates;
    for (std::uint32_t j = 0; j < images.size(); ++j) {
      if (j == i || given.Contains(i, j)) continue;
      const auto distance_m = Distance_m(images[i], images[j]);
      if (distance_m && *distance_m <= options.spatial_radius_m) {
        candidates.emplace_back(*distance_m, j);
      }
    }
    AddBest(i, std::move(candidates), options.spatial_neighbours, pairs);
  }
}

void AddByAppearance(Images images, const PairingOptions& options, PairSet& pairs) {
  std::vector<std::span<const Descriptor>> descriptors;
  for (const PairingImage& image : images) descriptors.push_back(image.descriptors);
  const internal::AppearanceIndex index(descriptors,
                                        {.seed = options.seed, .parallelism = options.parallelism});
  const PairSet given = pairs;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    const std::vector<float> similarities = index.Similarities(i);
    std::vector<std::pair<double, std::uint32_t>> candidates;
    for (std::uint32_t j = 0; j < images.size(); ++j) {
      if (j == i || similarities[j] <= 0 || given.Contains(i, j)) continue;
      const auto distance_m = Distance_m(images[i], images[j]);
      if (distance_m && *distance_m > kRetrievalRadii * options.spatial_radius_m) continue;
      candidates.emplace_back(-similarities[j], j);
    }
    AddBest(i, std::move(candidates), options.retrieval_neighbours, pairs);
  }
}

}  // namespace

Result<void> PairingOptions::Validate() const {
  for (const auto& [name, value] : {std::pair("sequential_neighbours", sequential_neighbours),
                                    std::pair("spatial_neighbours", spatial_neighbours),
                                    std::pair("retrieval_neighbours", retrieval_neighbours),
                                    std::pair("exhaustive_below", exhaustive_below)}) {
    if (value < 0) {
      return MakeError(ErrorCode::kInvalidArgument, "{}: expected 0 or more, found {}", name,
                       value);
    }
  }
  if (!(spatial_radius_m >= 0)) {
    return MakeError(ErrorCode::kInvalidArgument, "spatial_radius_m: expected 0 or more, found {}",
                     spatial_radius_m);
  }
  return {};
}

std::vector<ImagePair> SelectCandidatePairs(Images images, const PairingOptions& options) {
  PairSet pairs(images.size());
  if (images.size() <= static_cast<std::size_t>(options.exhaustive_below)) {
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      for (std::uint32_t j = i + 1; j < images.size(); ++j) pairs.Add(i, j);
    }
    return pairs.Sorted();
  }
  AddSequential(images, options, pairs);
  AddSpatial(images, options, pairs);
  if (options.retrieval_neighbours > 0) AddByAppearance(images, options, pairs);
  return pairs.Sorted();
}

}  // namespace waymark::mapping
