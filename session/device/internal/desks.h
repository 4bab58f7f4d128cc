// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "session/device/device_session.h"
#include "session/device/pose_tracker.h"
#include "session/state/messages.h"

/// The parts of a device session that decide when something is to be said. Pure: the caller tells
/// them the time of its steady clock. Thread-compatible.
namespace waymark::session::internal {

using Instant = std::chrono::steady_clock::time_point;

inline constexpr Instant kNever = Instant::max();

/// Joins, notices when the server falls silent, and joins again.
class JoinDesk {
 public:
  /// `first_attempt` should differ from those of earlier lives of the same device.
  explicit JoinDesk(std::uint32_t first_attempt)
      : first_attempt_(first_attempt), attempt_(first_attempt) {}

  enum class Outcome { kIgnored, kJoined, kRefused, kRemoved };

  /// The way to the server is a new one: joins again, at once.
  void Restart(Instant now);
  /// Whether a Hello, or a ping, is to be sent now; counted as sent.
  bool TakeHelloDue(Instant now);
  bool TakePingDue(Instant now);
  Instant NextDeadline() const;

  Outcome On(const Welcome& welcome, Instant now);
  void OnPong(const ClockPong& pong, Instant now);
  /// Another release is live; requires a welcome.
  void SetEpoch(std::uint64_t epoch) { welcome_->map.epoch = epoch; }

  std::uint32_t attempt() const { return attempt_; }
  /// The latest acceptance; absent before the first.
  const std::optional<Welcome>& welcome() const { return welcome_; }
  bool IsConnected() const { return is_connected_; }
  /// The server sent it away: it says nothing more.
  bool IsOver() const { return is_over_; }

 private:
  /// It doubles: the first Hellos may come before the bus has found the server, and go nowhere.
  static constexpr std::chrono::milliseconds kFirstHelloInterval{20};

  std::uint32_t first_attempt_;
  std::uint32_t attempt_;
  bool is_connected_ = false;
  bool is_over_ = false;
  std::optional<Welcome> welcome_;
  Instant next_hello_ = Instant::min();
  std::chrono::milliseconds hello_interval_ = kFirstHelloInterval;
  Instant next_ping_ = kNever;
  Instant last_heard_;
  int fast_pings_ = 0;  // left to send
};

/// One image under way at a time. A newer one takes its place when more of the older has still to
/// leave than the newer would take, or than has left; the latter not twice in a row, lest on a slow
/// network none ever arrives.
class ImageDesk {
 public:
  ImageDesk(std::chrono::duration<double> interval, std::chrono::duration<double> timeout)
      : interval_(interval), timeout_(timeout) {}

  enum class Offered { kRefused, kTaken, kInsteadOfOlder };
  /// Takes the frame if its turn has come. `waiting_bytes` of the image under way have not left
  /// yet; this one would take about `expected_bytes`.
  Offered Offer(const DeviceFrame& frame, Instant now, std::size_t waiting_bytes,
                std::size_t expected_bytes);
  bool HasFrame() const { return waiting_.has_value(); }
  /// A frame that waits to be sent; from then on it is under way.
  std::optional<DeviceFrame> TakeFrame(RequestNumber& request);
  /// The frame under way is encoded, and goes now.
  void NoteSent(std::size_t image_bytes, int width_px, Instant now);
  /// The clock that stamps frames was set forward by so much.
  void ShiftTime(std::chrono::nanoseconds by);
  /// It could not be sent.
  void Abandon();
  /// The frame that an answer belongs to, with when it was pushed; nothing if none waits for it.
  struct Match {
    SentFrame frame;
    Instant pushed, sent;
    std::size_t image_bytes = 0;
    int width_px = 0;
  };
  std::optional<Match> TakeMatch(RequestNumber request);
  /// Whether the image under way has been given up.
  bool TakeTimeout(Instant now);
  Instant NextDeadline() const;

 private:
  enum class Stage { kIdle, kWaiting, kUnderWay };

  std::chrono::duration<double> interval_;
  std::chrono::duration<double> timeout_;
  Stage stage_ = Stage::kIdle;
  std::optional<DeviceFrame> waiting_;
  std::optional<Match> sent_;
  std::optional<DeviceTime> last_time_;
  Instant pushed_;
  bool is_replacement_ = false;  // the image under way is
  std::uint32_t next_request_ = 1;
};

using Command = std::variant<AnchorCommand, RoomCommand>;

Uuid MakeUuid();
/// What a refused command is to the application.
Error ToError(const CommandReply& reply);

/// Commands are repeated until they are answered.
class CommandDesk {
 public:
  void Add(const Command& command, Instant now);
  /// Those to be sent now; counted as sent.
  std::vector<Command> TakeDue(Instant now);
  Instant NextDeadline() const;

  /// False: nobody waits for it.
  bool On(const CommandReply& reply);
  const CommandReply* FindReply(const Uuid& request) const;
  /// Ends waiting. What is known of it by then.
  struct Farewell {
    int sent = 0;
    std::string last_refusal;  ///< of an "unavailable" that did not pass
  };
  Farewell Remove(const Uuid& request);

 private:
  struct Entry {
    Command command;
    Instant next;
    int sent = 0;
    std::string last_refusal;
    std::optional<CommandReply> reply;
  };

  std::map<Uuid, Entry> entries_;
};

}  // namespace waymark::session::internal
