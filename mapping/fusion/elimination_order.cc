// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/elimination_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace waymark::mapping {
namespace {

class Dissection {
 public:
  Dissection(std::span<const Eigen::Vector2d> positions, std::span<const BlockEdge> edges)
      : positions_(positions),
        neighbours_(positions.size()),
        side_(positions.size(), Side::kBefore),
        part_(positions.size(), 0),
        rank_(positions.size(), 0) {
    for (const BlockEdge& edge : edges) {
      neighbours_[edge.first].push_back(edge.second);
      neighbours_[edge.second].push_back(edge.first);
    }
  }

  /// Nodes sorted along both axes: once for all, as parts keep the order of the whole.
  struct Sorted {
    std::array<std::vector<std::uint32_t>, 2> along;
  };

  Sorted SortAll() const {
    Sorted all;
    for (const int axis : {0, 1}) {
      std::vector<std::uint32_t>& nodes = all.along[axis];
      nodes.resize(positions_.size());
      std::iota(nodes.begin(), nodes.end(), 0u);
      std::sort(nodes.begin(), nodes.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(positions_[a][axis], a) < std::pair(positions_[b][axis], b);
      });
    }
    return all;
  }

  void Append(Sorted nodes, std::vector<std::uint32_t>& order) {
    constexpr std::size_t kSmall = 16;
    const Cut along_x = FindCut(nodes.along[0]), along_y = FindCut(nodes.along[1]);
    const int axis = along_x.crossing <= along_y.crossing ? 0 : 1;
    const Cut& cut = axis == 0 ? along_x : along_y;
    const std::vector<std::uint32_t>& sorted = nodes.along[axis];
    if (sorted.size() <= kSmall) {
      order.insert(order.end(), sorted.begin(), sorted.end());
      return;
    }
    std::vector<std::uint32_t> at;
    for (std::uint32_t rank = 0; rank < sorted.size(); ++rank) {
      const bool is_at = rank < cut.rank && cut.last_tie[rank] >= cut.rank;
      side_[sorted[rank]] = rank >= cut.rank ? Side::kAfter : is_at ? Side::kAt : Side::kBefore;
      if (is_at) at.push_back(sorted[rank]);
    }
    Sorted before, after;
    for (const int each : {0, 1}) {
      for (const std::uint32_t node : nodes.along[each]) {
        if (side_[node] == Side::kBefore) before.along[each].push_back(node);
        if (side_[node] == Side::kAfter) after.along[each].push_back(node);
      }
    }
    nodes = {};
    Append(std::move(before), order);
    Append(std::move(after), order);
    order.insert(order.end(), at.begin(), at.end());
  }

 private:
  enum class Side : std::uint8_t { kBefore, kAt, kAfter };

  struct Cut {
    std::vector<std::uint32_t> last_tie;  ///< by rank: the highest rank it is tied to
    std::uint32_t rank = 0;               ///< the first beyond the cut
    int crossing = 0;                     ///< nodes before it with a tie beyond
  };

  /// The cut across the axis of the order, not too far from the middle, that fewest nodes reach
  /// across.
  Cut FindCut(std::span<const std::uint32_t> sorted) {
    Cut cut;
    cut.last_tie.reserve(sorted.size());
    const auto size = static_cast<std::uint32_t>(sorted.size());
    ++current_part_;
    for (std::uint32_t rank = 0; rank < size; ++rank) {
      part_[sorted[rank]] = current_part_;
      rank_[sorted[rank]] = rank;
    }
    std::vector<int> change(size + 2, 0);  // of `crossing` from one rank to the next
    for (std::uint32_t rank = 0; rank < size; ++rank) {
      std::uint32_t last = rank;
      for (const std::uint32_t other : neighbours_[sorted[rank]]) {
        if (part_[other] == current_part_) last = std::max(last, rank_[other]);
      }
      cut.last_tie.push_back(last);
      ++change[rank + 1];
      --change[last + 1];
    }
    cut.crossing = std::numeric_limits<int>::max();
    int crossing = 0;
    for (std::uint32_t rank = 0; rank <= size * 7 / 10; ++rank) {
      crossing += change[rank];
      if (rank >= size * 3 / 10 && crossing < cut.crossing) {
        cut.crossing = crossing;
        cut.rank = rank;
      }
    }
    return cut;
  }

  std::span<const Eigen::Vector2d> positions_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<Side> side_;           // by node: of the last cut
  std::vector<std::uint32_t> part_;  // by node: the part it was last in
  std::vector<std::uint32_t> rank_;  // by node: in that part
  std::uint32_t current_part_ = 0;
};

}  // namespace

std::vector<std::uint32_t> ChooseEliminationOrder(std::span<const Eigen::Vector2d> positions,
                                                  std::span<const BlockEdge> edges) {
  std::vector<std::uint32_t> order;
  order.reserve(positions.size());
  Dissection dissection(positions, edges);
  dissection.Append(dissection.SortAll(), order);
  return order;
}

}  // namespace waymark::mapping
