// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <variant>

#include "session/device/clock_estimator.h"
#include "session/device/device_session.h"
#include "session/device/image_sizer.h"
#include "session/device/internal/area_desk.h"
#include "session/device/internal/burst_desk.h"
#include "session/device/internal/desks.h"
#include "session/device/internal/edit_desk.h"
#include "session/device/internal/tile_desk.h"
#include "session/device/pose_tracker.h"
#include "session/device/room_view.h"
#include "session/device/tile.h"
#include "session/wire/device_link.h"
#include "session/wire/inbox.h"

namespace waymark::session::internal {

/// The session. The application's calls, one worker and one thread for images, which take long to
/// encode and to localise, share the state under a mutex; the link's threads only leave messages in
/// the inbox.
class LiveSession final : public DeviceSession {
 public:
  static Result<std::unique_ptr<LiveSession>> Start(const DeviceOptions& options);
  ~LiveSession() override;

  /// Errors: as DeviceSession::Join.
  Result<void> AwaitWelcome();

  const DeviceId& id() const override { return id_; }
  SessionMap DescribeMap() const override;
  Result<void> PushFrame(const DeviceFrame& frame) override;
  void PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time) override;
  DevicePose Pose() const override;
  std::optional<ServerTime> SessionTime(DeviceTime instant) const override;
  std::vector<OtherDevice> Others() const override;
  Result<SharedAnchor> PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                   const std::string& kind, const std::string& payload,
                                   content::AnchorVisibility audience) override;
  Result<SharedAnchor> MoveAnchor(const SharedAnchor& anchor,
                                  const Transform<Map, Anchor>& map_from_anchor) override;
  Result<void> DeleteAnchor(const SharedAnchor& anchor) override;
  Result<SharedAnchor> BeginPlace(const Transform<Device, Anchor>& device_from_anchor,
                                  const std::string& kind, const std::string& payload,
                                  content::AnchorVisibility audience) override;
  Result<void> BeginMove(const SharedAnchor& anchor,
                         const Transform<Map, Anchor>& map_from_anchor) override;
  Result<void> BeginDelete(const SharedAnchor& anchor) override;
  std::vector<EditOutcome> TakeOutcomes() override;
  std::vector<SharedAnchor> Anchors() const override;
  std::optional<SharedAnchor> FindAnchor(const AnchorId& anchor) const override;
  bool HasSnapshot() const override;
  RoomStanding Standing() const override;
  Result<void> Kick(const DeviceId& device, const std::string& reason) override;
  Result<void> Readmit(const DeviceId& device) override;
  Result<void> SetCapacity(int devices) override;
  std::uint64_t Changes() const override { return changes_; }
  DeviceStatistics Statistics() const override;
  void Leave() override;

 private:
  struct WakeUp {};
  using Item = std::variant<wire::DeviceLink::Event, WakeUp>;

  LiveSession(const DeviceOptions& options, const DeviceId& id, std::uint32_t first_attempt,
              std::shared_ptr<const Tile> tile);

  // The thread for images.
  void WorkOnImages();
  void SendFrame();
  void AskTile();
  Result<void> Send(const DeviceFrame& frame, LocaliseQuery query);
  /// What travels of a frame, and the size in pixels that it speaks of.
  struct Encoded {
    std::vector<std::uint8_t> bytes;
    int width_px = 0;
    int height_px = 0;
  };
  Result<Encoded> Encode(const DeviceFrame& frame);
  static Result<Encoded> EncodeAsFeatures(const DeviceFrame& frame, int max_features);

  // The worker.
  void Work();
  void SendWhatIsDue();
  void Judge(const LocaliseAnswer& answer, const ImageDesk::Match& match);
  Instant NextDeadline() const;
  void On(const wire::DeviceLink::Event& event);
  void On(const Welcome& welcome);
  void On(const Presence& presence) { view_.On(presence); }
  void On(const wire::DeviceGone& gone);
  void On(const PoseBatch& batch) { view_.On(batch, SessionNow()); }
  void On(const LocaliseAnswer& answer);
  void On(const AnchorState& state) { view_.On(state); }
  void On(const wire::AnchorGone& gone) { view_.OnGone(gone.anchor, gone.is_own); }
  void On(const CommandReply& reply);
  void On(const RoomState& state) { view_.On(state); }
  void On(const OwnerState& state) { view_.On(state); }
  void On(const AreaState& state);
  void On(const MapState& state);
  void On(const ClockPong& pong);

  std::optional<localiser::LocalisedPose> InLiveMap(const LocaliseAnswer& answer) const;
  LocaliseQuery MakeQuery(const DeviceFrame& frame, RequestNumber request) const;
  /// A command with a request of its own, as the application's call says.
  Result<AnchorCommand> ToPlace(const Transform<Device, Anchor>& device_from_anchor,
                                const std::string& kind, const std::string& payload,
                                content::AnchorVisibility audience) const;  // with mutex_ held
  AnchorCommand ToMove(const SharedAnchor& anchor,
                       const Transform<Map, Anchor>& map_from_anchor) const;  // with mutex_ held
  Result<void> Begin(const AnchorCommand& command, EditDesk::Ending ending);  // with mutex_ held
  Result<CommandReply> Await(const AnchorCommand& command, std::unique_lock<std::mutex>& lock);
  void SendEdits(Instant now);  // with mutex_ held
  /// It was answered, or is not waited for any more.
  void FinishEdit(const Uuid& request, bool is_overdue = false);  // with mutex_ held
  void FinishEdits(const Error& error);                           // with mutex_ held
  Result<void> Perform(RoomCommand command);
  /// Sends, repeats and waits; `about` names it in errors. `sent` counts.
  Result<CommandReply> Await(const Command& command, const std::string& about, int& sent);
  void SayArea(Instant now);                     // with mutex_ held
  std::optional<Eigen::Vector2d> About() const;  // with mutex_ held
  std::size_t ExpectedBytes() const;             // with mutex_ held
  SessionMap CurrentMap() const;                 // with mutex_ held
  bool IsTileCurrent() const;                    // with mutex_ held
  Error NotIn() const;                           // with mutex_ held
  DevicePose CurrentPose() const;                // with mutex_ held
  ServerTime SessionNow() const;                 // with mutex_ held
  DeviceTime ToSteady(DeviceTime stamp) const;   // with mutex_ held
  std::string ServerName() const;

  const DeviceOptions options_;
  const DeviceId id_;
  const std::shared_ptr<const Tile> tile_;  // may be absent
  Inbox<Item> inbox_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::condition_variable image_due_;

  // Guarded by mutex_.
  JoinDesk join_;
  ImageDesk images_;
  BurstDesk bursts_;
  TileDesk tile_desk_;
  ImageSizer sizer_;
  CommandDesk commands_;
  EditDesk edits_;
  AreaDesk areas_;
  std::optional<GeoPoint> about_;  // where it is, until it has a pose
  ClockEstimator session_clock_;
  StampClock stamp_clock_;
  PoseTracker tracker_;
  Eigen::Vector3d gaze_in_device_ = Eigen::Vector3d::Zero();  // of the camera, once known
  RoomView view_;
  std::uint32_t last_swap_ = 0;  // of the present run
  Placements placements_;        // of the live release, as told with its swap
  DeviceStatistics statistics_;
  RoomStanding standing_;
  std::optional<Welcome> refusal_;
  std::uint32_t next_ping_number_ = 0;
  DeviceTime last_report_;
  Instant last_refresh_;
  bool has_left_ = false;

  std::atomic<std::uint64_t> changes_ = 0;
  std::atomic<bool> is_stopping_ = false;
  std::unique_ptr<wire::DeviceLink> link_;  // set before the worker starts
  std::thread worker_;
  std::thread image_thread_;
};

}  // namespace waymark::session::internal
