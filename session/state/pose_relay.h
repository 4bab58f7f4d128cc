// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "session/state/messages.h"
#include "session/state/pose_grid.h"

namespace waymark::session {

struct RelayOptions {
  double bytes_per_s = 25'000;       ///< of poses to one listener, >= 2,000
  std::size_t max_neighbours = 128;  ///< weighed against each other for one listener, >= 16

  Result<void> Validate() const;
};

/// Decides who is told whose pose, once in kTicksPerFrame ticks, within a budget for each listener:
/// in any time t no more than bytes_per_s * (t + 0.1 s), 64 for a batch and 24 for each pose in it.
/// Those that would be seen to move most come first: near, fast, and where the listener looks. In
/// numbers, with v a phone's speed (0.15 m/s at least), d its distance (1 m at least) and g = 1
/// within 60 degrees of the gaze and 1/4 elsewhere, it moves by v g / d on the screen, in rad/s.
///
/// - A pose is due when it is new and either nearer than 20 m, or it would be seen to have moved by
///   2 mrad since the listener was last told, or 10 s have passed.
/// - Of the neighbours that are due, those that move most have half of the places to themselves;
///   the rest go to those that have moved most since they were last told.
/// - An eighth of the places, and all that are left, go to everybody in turn, near or far: with n
///   in the room and k places in a frame nobody is forgotten for longer than 10 s and 8 n / k
///   frames.
/// - Listeners of successive numbers have their frames in successive ticks.
///
/// The cost for one listener is bounded by `max_neighbours`, whatever the size of the crowd. Pure:
/// the same calls give the same choices. Thread-compatible.
class PoseRelay {
 public:
  using Slot = std::uint32_t;  ///< of a pose, until the next Hear

  /// Who listens, and what it has been told.
  class Listener {
   public:
    explicit Listener(DeviceNumber number) : number_(number) {}
    DeviceNumber number() const { return number_; }
    /// Where it looks when that does not come with its pose; a unit vector or zero.
    void LookAlong(const Eigen::Vector3d& gaze_in_map) { gaze_in_map_ = gaze_in_map; }

   private:
    friend class PoseRelay;
    struct Told {
      std::uint32_t version = 0;  ///< of the pose; 0: never
      std::uint32_t at_ms = 0;
    };

    DeviceNumber number_;
    std::optional<std::uint32_t> frame_;  // that it was told last
    Eigen::Vector3d gaze_in_map_ = Eigen::Vector3d::Zero();
    std::vector<Told> told_;        // by slot
    Slot turn_ = 0;                 // whose turn it is next
    double allowance_bytes_ = 1e9;  // cut to what it may be when it is used
    std::uint32_t allowance_at_ms_ = 0;
  };

  explicit PoseRelay(const RelayOptions& options) : options_(options) {}

  /// What is told of a tick; poses of another epoch than before replace all that were known.
  void Hear(std::uint64_t epoch, std::span<const SharedPose> poses, ServerTime now);
  /// Those of which nothing was heard for 2 s are gone; the rest is ready to be chosen from. `tick`
  /// is of what was heard; some may be missing.
  void FinishHearing(std::uint32_t tick);
  /// Forgets all poses: those to come are of another run, where numbers mean others.
  void Clear();

  /// What this listener is told now, nothing in a tick of others; valid until the next call. Counts
  /// as told.
  std::span<const Slot> Choose(Listener& listener);
  /// By slot; those of who is gone are there too.
  std::span<const SharedPose> poses() const { return poses_; }
  /// How many poses were looked at for choices so far.
  std::uint64_t Looks() const { return looks_; }

 private:
  struct Entry {
    bool is_here = false;
    std::uint32_t version = 0;
    std::uint32_t heard_ms = 0;
  };
  struct Candidate {
    Slot slot;
    double motion;      ///< on the screen, rad/s
    double moved;       ///< since it was last told, rad
    double distance_m;  ///< 0 without a viewpoint
  };
  /// What is asked of every pose for every listener, close together in memory.
  struct Seen {
    Eigen::Vector3d position_m;
    double speed_mps;
  };
  /// From where the choice is made.
  struct Viewpoint {
    Eigen::Vector3d position_m;
    Eigen::Vector3d gaze;
  };

  std::uint32_t FrameOf(const Listener& listener) const;
  std::optional<Viewpoint> ViewpointOf(const Listener& listener) const;
  Candidate Weigh(Slot slot, const std::optional<Viewpoint>& viewpoint,
                  const Listener& listener) const;
  bool IsNew(Slot slot, const Listener& listener) const;
  bool IsDue(const Candidate& candidate, const Listener& listener) const;
  std::size_t PlacesFor(Listener& listener) const;
  void ChooseNeighbours(const Viewpoint& viewpoint, std::size_t places, Listener& listener);
  void ChooseInTurn(const std::optional<Viewpoint>& viewpoint, std::size_t places,
                    Listener& listener);
  void Tell(Slot slot, Listener& listener);
  double SinceTold_s(Slot slot, const Listener& listener) const;

  RelayOptions options_;
  std::uint64_t epoch_ = 0;
  std::optional<ServerTime> begin_;
  std::uint32_t now_ms_ = 0;  // since the beginning
  std::uint32_t last_version_ = 0;
  std::vector<SharedPose> poses_;  // by slot
  std::vector<Entry> entries_;     // by slot
  std::vector<Seen> seen_;         // by slot; of the tick
  std::vector<Slot> free_;
  std::unordered_map<DeviceNumber, Slot> slots_;
  PoseGrid grid_;
  std::uint32_t tick_ = 0;
  std::uint64_t looks_ = 0;
  std::vector<Candidate> candidates_;  // of the present choice
  std::vector<Slot> chosen_;
};

}  // namespace waymark::session
