// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/elimination_order.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace waymark::mapping {
namespace {

class Dissection {
 public:
  Dissection(std::span<const Eigen::Vector2d> positions, std::span<const BlockEdge> edges)
      : positions_(positions),
        neighbours_(positions.size()),
        part_(positions.size(), 0),
        rank_(positions.size(), 0) {
    for (const BlockEdge& edge : edges) {
      neighbours_[edge.first].push_back(edge.second);
      neighbours_[edge.second].push_back(edge.first);
    }
  }

  void Append(std::vector<std::uint32_t> nodes, std::vector<std::uint32_t>& order) {
    constexpr std::size_t kSmall = 16;
    Cut along_x = FindCut(nodes, 0), along_y = FindCut(nodes, 1);
    Cut& cut = along_x.crossing <= along_y.crossing ? along_x : along_y;
    if (nodes.size() <= kSmall) {
      order.insert(order.end(), cut.sorted.begin(), cut.sorted.end());
      return;
    }
    std::vector<std::uint32_t> before, at, after;
    for (std::uint32_t rank = 0; rank < cut.sorted.size(); ++rank) {
      auto& side = rank >= cut.rank ? after : cut.last_tie[rank] >= cut.rank ? at : before;
      side.push_back(cut.sorted[rank]);
    }
    nodes.clear();
    Append(std::move(before), order);
    Append(std::move(after), order);
    order.insert(order.end(), at.begin(), at.end());
  }

 private:
  struct Cut {
    std::vector<std::uint32_t> sorted;    ///< nodes along the axis
    std::vector<std::uint32_t> last_tie;  ///< by rank: the highest rank it is tied to
    std::uint32_t rank = 0;               ///< the first beyond the cut
    int crossing = 0;                     ///< nodes before it with a tie beyond
  };

  /// The cut across an axis, not too far from the middle, that fewest nodes reach across.
  Cut FindCut(std::span<const std::uint32_t> nodes, int axis) {
    Cut cut{.sorted = {nodes.begin(), nodes.end()}, .last_tie = {}};
    std::sort(cut.sorted.begin(), cut.sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(positions_[a][axis], a) < std::pair(positions_[b][axis], b);
    });
    const auto size = static_cast<std::uint32_t>(nodes.size());
    ++current_part_;
    for (std::uint32_t rank = 0; rank < size; ++rank) {
      part_[cut.sorted[rank]] = current_part_;
      rank_[cut.sorted[rank]] = rank;
    }
    std::vector<int> change(size + 2, 0);  // of `crossing` from one rank to the next
    for (std::uint32_t rank = 0; rank < size; ++rank) {
      std::uint32_t last = rank;
      for (const std::uint32_t other : neighbours_[cut.sorted[rank]]) {
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
  std::vector<std::uint32_t> part_;  // by node: the part it was last in
  std::vector<std::uint32_t> rank_;  // by node: in that part
  std::uint32_t current_part_ = 0;
};

}  // namespace

std::vector<std::uint32_t> ChooseEliminationOrder(std::span<const Eigen::Vector2d> positions,
                                                  std::span<const BlockEdge> edges) {
  std::vector<std::uint32_t> all, order;
  for (std::uint32_t i = 0; i < positions.size(); ++i) all.push_back(i);
  Dissection(positions, edges).Append(std::move(all), order);
  return order;
}

}  // namespace waymark::mapping
