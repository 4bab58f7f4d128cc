// SPDX-License-Identifier: Apache-2.0
#include "session/wire/frames.h"

#include <optional>

#include "session/wire/internal/cdr_reader.h"
#include "session/wire/internal/cdr_writer.h"
#include "session/wire/internal/codec.h"
#include "session/wire/internal/layouts.h"

namespace waymark::session::wire {
namespace {

constexpr std::size_t kHeaderBytes = 4;

/// Numbers are for ever: a client of any age relies on them. 2 and 19 were poses before they had
/// velocities.
template <typename Message>
inline constexpr std::uint8_t kKind = 0;
template <>
inline constexpr std::uint8_t kKind<Hello> = 1;
template <>
inline constexpr std::uint8_t kKind<PoseReport> = 6;
template <>
inline constexpr std::uint8_t kKind<LocaliseQuery> = 3;
template <>
inline constexpr std::uint8_t kKind<AnchorCommand> = 4;
template <>
inline constexpr std::uint8_t kKind<ClockPing> = 5;
template <>
inline constexpr std::uint8_t kKind<RoomCommand> = 8;
template <>
inline constexpr std::uint8_t kKind<AreaReport> = 9;
template <>
inline constexpr std::uint8_t kKind<Welcome> = 17;
template <>
inline constexpr std::uint8_t kKind<Presence> = 18;
template <>
inline constexpr std::uint8_t kKind<PoseBatch> = 26;
template <>
inline constexpr std::uint8_t kKind<LocaliseAnswer> = 20;
template <>
inline constexpr std::uint8_t kKind<AnchorState> = 21;
template <>
inline constexpr std::uint8_t kKind<CommandReply> = 22;
template <>
inline constexpr std::uint8_t kKind<RoomState> = 23;
template <>
inline constexpr std::uint8_t kKind<MapState> = 24;
template <>
inline constexpr std::uint8_t kKind<ClockPong> = 25;
template <>
inline constexpr std::uint8_t kKind<OwnerState> = 27;
template <>
inline constexpr std::uint8_t kKind<AreaState> = 28;

template <typename Message>
std::vector<std::uint8_t> EncodeWire(const WireOf<Message>& wire, bool is_end) {
  static_assert(kKind<Message> != 0);
  std::vector<std::uint8_t> frame{kKind<Message>, is_end, 0, 0};
  CdrWriter writer(frame);
  writer(wire);
  return frame;
}

/// A message, or the end of what one names.
struct Encoder {
  template <typename Message>
  std::vector<std::uint8_t> operator()(const Message& message) const {
    Scratch scratch;
    return EncodeWire<Message>(Encode(message, scratch), false);
  }
  std::vector<std::uint8_t> operator()(const Farewell& farewell) const {
    waymark_Hello key{};
    SetId(key.device, farewell.device);
    return EncodeWire<Hello>(key, true);
  }
  std::vector<std::uint8_t> operator()(const DeviceGone& gone) const {
    waymark_Presence key{};
    SetId(key.device, gone.device);
    return EncodeWire<Presence>(key, true);
  }
  std::vector<std::uint8_t> operator()(const AnchorGone& gone) const {
    return EncodeWire<AnchorState>(AnchorKey(gone.anchor, gone.is_own), true);
  }
};

/// Tries one type after the other until the kind fits. `Any` is what the result is of.
template <typename Any>
class Decoder {
 public:
  explicit Decoder(std::span<const std::uint8_t> frame) : frame_(frame) {}

  template <typename Message>
  Decoder& Try() {
    return TryWith<Message>([](const WireOf<Message>&) -> Result<Any> {
      return MakeError(ErrorCode::kCorrupt, "frame: nothing of this kind ends");
    });
  }

  template <typename Message, typename OnEnd>
  Decoder& TryWith(OnEnd on_end) {
    if (found_ || frame_.size() < kHeaderBytes || frame_[0] != kKind<Message>) return *this;
    found_ = Parse<Message>(on_end);
    return *this;
  }

  Result<Any> Take() {
    if (found_) return *std::move(found_);
    return MakeError(ErrorCode::kCorrupt, "frame: {} bytes of kind {} are no message here",
                     frame_.size(), frame_.empty() ? 0 : frame_[0]);
  }

 private:
  template <typename Message, typename OnEnd>
  Result<Any> Parse(OnEnd on_end) const {
    Scratch scratch;
    WireOf<Message> wire{};
    CdrReader reader(frame_.subspan(kHeaderBytes), scratch);
    reader(wire);
    if (!reader.IsComplete()) {
      return MakeError(ErrorCode::kCorrupt, "frame: {} bytes are no message of kind {}",
                       frame_.size(), frame_[0]);
    }
    if (frame_[1] != 0) return on_end(wire);
    WAYMARK_TRY_ASSIGN(Message message, Decode(wire));
    return Any(std::move(message));
  }

  std::span<const std::uint8_t> frame_;
  std::optional<Result<Any>> found_;
};

}  // namespace

std::vector<std::uint8_t> EncodeFrame(const Upward& message) {
  return std::visit(Encoder{}, message);
}

std::vector<std::uint8_t> EncodeFrame(const Downward& message) {
  return std::visit(Encoder{}, message);
}

Result<Upward> DecodeUpward(std::span<const std::uint8_t> frame) {
  return Decoder<Upward>(frame)
      .TryWith<Hello>([](const waymark_Hello& key) -> Result<Upward> {
        return Upward(Farewell{GetId<DeviceId>(key.device)});
      })
      .Try<PoseReport>()
      .Try<LocaliseQuery>()
      .Try<AnchorCommand>()
      .Try<ClockPing>()
      .Try<RoomCommand>()
      .Try<AreaReport>()
      .Take();
}

Result<Downward> DecodeDownward(std::span<const std::uint8_t> frame) {
  return Decoder<Downward>(frame)
      .TryWith<Presence>([](const waymark_Presence& key) -> Result<Downward> {
        return Downward(DeviceGone{GetId<DeviceId>(key.device)});
      })
      .TryWith<AnchorState>([](const waymark_AnchorState& key) -> Result<Downward> {
        return Downward(AnchorGone{GetId<AnchorId>(key.anchor), IsPrivate(key)});
      })
      .Try<Welcome>()
      .Try<PoseBatch>()
      .Try<LocaliseAnswer>()
      .Try<CommandReply>()
      .Try<RoomState>()
      .Try<MapState>()
      .Try<ClockPong>()
      .Try<OwnerState>()
      .Try<AreaState>()
      .Take();
}

}  // namespace waymark::session::wire
