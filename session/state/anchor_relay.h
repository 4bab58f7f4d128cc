// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "session/state/anchors.h"

namespace waymark::session {

/// Which anchors of a room matter to a device: those in its area. A device is told every change
/// within, what comes in and what leaves; and once it is told how many there are it can tell
/// whether it knows them all. Costs grow with the area, not with the room. Pure; thread-compatible.
class AnchorRelay {
 public:
  /// An anchor as it stood.
  struct Standing {
    RunId run{};
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in the map
    std::uint64_t digest = 0;
  };
  /// What happened to an anchor.
  struct Change {
    std::optional<Standing> before, after;
  };
  /// What a device is to be told, having asked for an area: anchors that it does not know; and
  /// those that it knows and that do not matter any more, of which it is told nothing.
  struct News {
    std::vector<AnchorId> coming, leaving;
  };
  /// A device that asked for an area.
  class Listener;

  /// `max_in_area`: of so many the nearest are told, and the area ends there; > 0.
  explicit AnchorRelay(std::size_t max_in_area = 5000) : max_in_area_(max_in_area) {}

  Change Put(const AnchorState& state);
  Change Remove(const AnchorId& anchor);
  /// What was said in runs of the server that are over no longer holds, and nobody is told of its
  /// end.
  void ForgetRuns(const std::function<bool(RunId)>& is_over);
  /// How many the room holds. What is told of areas waits until those that are known are these.
  void Expect(RunId run, std::size_t count, std::uint64_t digest);
  bool IsComplete() const;

  /// The listener's next area. The same report again asks for its state again, and no more.
  News Listen(Listener& listener, const AreaReport& report) const;

 private:
  struct Cell {
    std::int32_t x = 0, y = 0;
    friend bool operator==(const Cell&, const Cell&) = default;
  };
  struct CellHash {
    std::size_t operator()(const Cell& cell) const;
  };
  struct Near {
    double distance_m = 0;
    AnchorId anchor;
    const Standing* standing;
  };

  static Cell CellOf(const Eigen::Vector2d& position_m);
  void TakeOut(const AnchorId& anchor, const Standing& standing);
  std::vector<Near> FindIn(const AnchorArea& area) const;

  std::size_t max_in_area_;
  std::map<AnchorId, Standing> anchors_;
  std::unordered_map<Cell, std::vector<AnchorId>, CellHash> grid_;
  struct Tally {
    std::size_t count = 0;
    std::uint64_t digest = 0;
    friend bool operator==(const Tally&, const Tally&) = default;
  };
  std::map<RunId, Tally> of_runs_;
  std::optional<std::pair<RunId, Tally>> expected_;
};

class AnchorRelay::Listener {
 public:
  explicit Listener(DeviceId device) : device_(std::move(device)) {}

  /// Whether the device must be told of the change.
  bool Concerns(const Change& change);
  /// They are about to be told anew.
  void ForgetAnchors();
  /// The state of its area, when it is due and all of the room is known.
  std::optional<AreaState> TakeState(const AnchorRelay& relay);

 private:
  friend class AnchorRelay;

  DeviceId device_;
  std::uint32_t number_ = 0;
  std::optional<AnchorArea> area_;  // absent: has not asked yet
  std::map<RunId, Tally> in_area_;
  bool is_due_ = false;
};

}  // namespace waymark::session
