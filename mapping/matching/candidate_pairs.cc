// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/candidate_pairs.h"

#include <algorithm>
#include <cmath>
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

/// Images of a video follow each other in steps between these.
constexpr double kLeastFrameStep_s = 1e-3;
constexpr double kMostFrameStep_s = 0.5;

/// The images of each sequence in the order of time.
class Sequences {
 public:
  Sequences(Images images, double video_s)
      : images_(images), video_s_(video_s), places_(images.size()) {
    for (std::uint32_t i = 0; i < images.size(); ++i) by_name_[images[i].sequence].push_back(i);
    for (auto& [name, sequence] : by_name_) {
      std::ranges::stable_sort(sequence, {}, [&](std::uint32_t i) { return images[i].time; });
      for (std::size_t k = 0; k < sequence.size(); ++k) places_[sequence[k]] = k;
    }
  }

  const std::map<std::string, std::vector<std::uint32_t>>& by_name() const { return by_name_; }

  /// Whether the two are frames of one video and so close in time that the recorder cannot have
  /// come back: successors tell all.
  bool AreOneTake(std::uint32_t a, std::uint32_t b) const {
    if (images_[a].sequence != images_[b].sequence) return false;
    const double apart_s = std::abs(Seconds(images_[a].time - images_[b].time));
    const auto steps =
        static_cast<double>(std::max(places_[a], places_[b]) - std::min(places_[a], places_[b]));
    return apart_s <= video_s_ && apart_s >= kLeastFrameStep_s * steps &&
           apart_s <= kMostFrameStep_s * steps;
  }

 private:
  Images images_;
  double video_s_;
  std::vector<std::size_t> places_;  // by image, in its sequence
  std::map<std::string, std::vector<std::uint32_t>> by_name_;
};

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

void AddSequential(const Sequences& sequences, const PairingOptions& options, PairSet& pairs) {
  const auto neighbours = static_cast<std::size_t>(options.sequential_neighbours);
  for (const auto& [name, sequence] : sequences.by_name()) {
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const auto add = [i, &sequence = sequence, &pairs](std::size_t step) {
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
void AddSpatial(Images images, const Sequences& sequences, const PairingOptions& options,
                PairSet& pairs) {
  const PairSet given = pairs;
  for (std::uint32_t i = 0; i < images.size(); ++i) {
    std::vector<std::pair<double, std::uint32_t>> candidates;
    for (std::uint32_t j = 0; j < images.size(); ++j) {
      if (j == i || given.Contains(i, j) || sequences.AreOneTake(i, j)) continue;
      const auto distance_m = Distance_m(images[i], images[j]);
      if (distance_m && *distance_m <= options.spatial_radius_m) {
        candidates.emplace_back(*distance_m, j);
      }
    }
    AddBest(i, std::move(candidates), options.spatial_neighbours, pairs);
  }
}

void AddByAppearance(Images images, const Sequences& sequences, const PairingOptions& options,
                     PairSet& pairs) {
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
      if (sequences.AreOneTake(i, j)) continue;
      const auto distance_m = Distance_m(images[i], images[j]);
      if (distance_m && *distance_m > kRetrievalRadii * options.spatial_radius_m) continue;
      candidates.emplace_back(-similarities[j], j);
    }
    AddBest(i, std::move(candidates), options.retrieval_neighbours, pairs);
  }
}

/// Then nothing is left to be found by its look.
bool IsOneTake(Images images, const Sequences& sequences) {
  return std::ranges::all_of(sequences.by_name(), [&](const auto& one) {
    return one.second.size() == images.size() &&
           sequences.AreOneTake(one.second.front(), one.second.back());
  });
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
  for (const auto& [name, value] :
       {std::pair("spatial_radius_m", spatial_radius_m), std::pair("video_s", video_s)}) {
    if (!(value >= 0)) {
      return MakeError(ErrorCode::kInvalidArgument, "{}: expected 0 or more, found {}", name,
                       value);
    }
  }
  return {};
}

std::vector<ImagePair> SelectCandidatePairs(Images images, const PairingOptions& options) {
  PairSet pairs(images.size());
  const Sequences sequences(images, options.video_s);
  AddSequential(sequences, options, pairs);
  if (images.size() <= static_cast<std::size_t>(options.exhaustive_below)) {
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      for (std::uint32_t j = i + 1; j < images.size(); ++j) {
        if (!sequences.AreOneTake(i, j)) pairs.Add(i, j);
      }
    }
    return pairs.Sorted();
  }
  AddSpatial(images, sequences, options, pairs);
  if (options.retrieval_neighbours > 0 && !IsOneTake(images, sequences)) {
    AddByAppearance(images, sequences, options, pairs);
  }
  return pairs.Sorted();
}

}  // namespace waymark::mapping
