// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/tracks.h"

#include <algorithm>
#include <numeric>

namespace waymark::mapping::internal {
namespace {

// Union-find over all features whose sets remember their elements.
class FeatureSets {
 public:
  explicit FeatureSets(std::span<const std::size_t> feature_counts) : offsets_(1, 0) {
    for (std::size_t count : feature_counts) offsets_.push_back(offsets_.back() + count);
    parent_.resize(offsets_.back());
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    elements_.resize(offsets_.back());
  }

  void Join(const TrackElement& a, const TrackElement& b) {
    std::size_t into = Find(Node(a));
    std::size_t from = Find(Node(b));
    if (into == from) return;
    if (elements_[into].empty()) elements_[into].push_back(a);
    if (elements_[from].empty()) elements_[from].push_back(b);
    if (elements_[into].size() < elements_[from].size()) std::swap(into, from);
    if (ShareAnImage(elements_[into], elements_[from])) return;
    std::vector<TrackElement> merged;
    std::merge(elements_[into].begin(), elements_[into].end(), elements_[from].begin(),
               elements_[from].end(), std::back_inserter(merged), ByImage);
    elements_[into] = std::move(merged);
    elements_[from] = {};
    parent_[from] = into;
  }

  std::vector<std::vector<TrackElement>> TakeTracks() {
    std::vector<std::vector<TrackElement>> tracks;
    for (auto& elements : elements_) {
      if (elements.size() >= 2) tracks.push_back(std::move(elements));
    }
    return tracks;
  }

 private:
  static bool ByImage(const TrackElement& a, const TrackElement& b) { return a.image < b.image; }

  static bool ShareAnImage(std::span<const TrackElement> a, std::span<const TrackElement> b) {
    auto i = a.begin();
    auto j = b.begin();
    while (i != a.end() && j != b.end()) {
      if (i->image == j->image) return true;
      i->image < j->image ? (void)++i : (void)++j;
    }
    return false;
  }

  std::size_t Node(const TrackElement& element) const {
    return offsets_[element.image] + element.feature;
  }

  std::size_t Find(std::size_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }

  std::vector<std::size_t> offsets_;
  std::vector<std::size_t> parent_;
  std::vector<std::vector<TrackElement>> elements_;  // of roots; empty: only the node itself
};

}  // namespace

std::vector<std::vector<TrackElement>> BuildTracks(std::span<const VerifiedPair> pairs,
                                                   std::span<const std::size_t> feature_counts) {
  std::vector<const VerifiedPair*> order;
  for (const VerifiedPair& pair : pairs) order.push_back(&pair);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->matches.size() > b->matches.size();
  });
  FeatureSets sets(feature_counts);
  for (const VerifiedPair* pair : order) {
    for (const FeatureMatch& match : pair->matches) {
      sets.Join({pair->images.first, match.first}, {pair->images.second, match.second});
    }
  }
  return sets.TakeTracks();
}

}  // namespace waymark::mapping::internal
