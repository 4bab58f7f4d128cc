// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/record_codec.h"

#include <bit>
#include <concepts>
#include <cstddef>

#include "content_store/anchor_rules.h"

namespace waymark::content::internal {
namespace {

constexpr std::uint8_t kFirstFormat = 1;
constexpr std::uint8_t kStateFormat = 2;  // has the extension
enum StateKind : std::uint8_t { kLive = 0, kDeleted = 1 };

/// Appends little-endian numbers and length-prefixed texts.
class Writer {
 public:
  template <std::unsigned_integral T>
  void Number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes_ += static_cast<char>(value >> (8 * i));
  }
  void Real(double value) { Number(std::bit_cast<std::uint64_t>(value)); }
  void Time(std::int64_t value) { Number(static_cast<std::uint64_t>(value)); }
  void Text(std::string_view text) {
    Number(static_cast<std::uint32_t>(text.size()));
    bytes_ += text;
  }
  void Pose(const Rigid3& pose) {
    for (const double v : pose.translation()) Real(v);
    for (const double v : pose.rotation().coeffs()) Real(v);  // x, y, z, w
  }
  std::string Take() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what Writer wrote. Past the end, or after a first failure, everything reads as zero.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && rest_.empty(); }

  template <std::unsigned_integral T>
  T Number() {
    T value = 0;
    const std::string_view bytes = Take(sizeof(T));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      value = static_cast<T>(
          value | static_cast<T>(static_cast<T>(static_cast<std::uint8_t>(bytes[i])) << (8 * i)));
    }
    return value;
  }
  double Real() { return std::bit_cast<double>(Number<std::uint64_t>()); }
  std::int64_t Time() { return static_cast<std::int64_t>(Number<std::uint64_t>()); }
  std::string Text() { return std::string(Take(Number<std::uint32_t>())); }
  Rigid3 Pose() {
    double v[7];
    for (double& value : v) value = Real();
    return {Eigen::Quaterniond(v[6], v[3], v[4], v[5]), Eigen::Vector3d(v[0], v[1], v[2])};
  }

 private:
  std::string_view Take(std::size_t count) {
    ok_ = ok_ && count <= rest_.size();
    if (!ok_) return {};
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }

  std::string_view rest_;
  bool ok_ = true;
};

void WriteContent(Writer& out, const AnchorRecord& record) {
  out.Text(record.owner);
  out.Pose(record.map_from_anchor.rigid());
  out.Number(record.epoch);
  out.Real(record.place.latitude.radians());
  out.Real(record.place.longitude.radians());
  out.Real(record.place.ellipsoid_height_m);
  out.Time(record.created_utc_ms);
  out.Time(record.changed_utc_ms);
  out.Text(record.kind);
  out.Number(static_cast<std::uint8_t>(record.attachments.size()));
  for (const SubmapAttachment& attachment : record.attachments) {
    out.Text(attachment.submap.text());
    out.Pose(attachment.submap_from_anchor.rigid());
  }
  out.Text(record.payload);
}

void ReadContent(Reader& in, AnchorRecord& record) {
  record.owner = in.Text();
  record.map_from_anchor = Transform<Map, Anchor>(in.Pose());
  record.epoch = in.Number<std::uint64_t>();
  record.place.latitude = Angle::Radians(in.Real());
  record.place.longitude = Angle::Radians(in.Real());
  record.place.ellipsoid_height_m = in.Real();
  record.created_utc_ms = in.Time();
  record.changed_utc_ms = in.Time();
  record.kind = in.Text();
  for (int left = in.Number<std::uint8_t>(); left > 0 && in.ok(); --left) {
    SubmapId submap(in.Text());
    record.attachments.push_back({std::move(submap), Transform<Submap, Anchor>(in.Pose())});
  }
  record.payload = in.Text();
}

enum ExtensionBit : std::uint8_t { kHasLink = 1, kExpires = 2, kUnsupported = 4 };
constexpr std::uint8_t kAllBits = kHasLink | kExpires | kUnsupported;

void WriteExtension(Writer& out, const AnchorRecord& record) {
  out.Number(static_cast<std::uint8_t>(record.visibility));
  out.Number(static_cast<std::uint8_t>(record.editing));
  out.Number(static_cast<std::uint8_t>((record.link ? kHasLink : 0) |
                                       (record.expires_utc_ms ? kExpires : 0) |
                                       (record.unsupported_since_epoch ? kUnsupported : 0)));
  if (record.link) {
    out.Text(record.link->uri);
    out.Text(record.link->sha256);
  }
  if (record.expires_utc_ms) out.Time(*record.expires_utc_ms);
  if (record.unsupported_since_epoch) out.Number(*record.unsupported_since_epoch);
}

/// Returns whether all bits are known; Validate judges the values.
bool ReadExtension(Reader& in, AnchorRecord& record) {
  record.visibility = static_cast<AnchorVisibility>(in.Number<std::uint8_t>());
  record.editing = static_cast<AnchorEditing>(in.Number<std::uint8_t>());
  const auto bits = in.Number<std::uint8_t>();
  if ((bits & kHasLink) != 0) {
    record.link.emplace();
    record.link->uri = in.Text();
    record.link->sha256 = in.Text();
  }
  if ((bits & kExpires) != 0) record.expires_utc_ms = in.Time();
  if ((bits & kUnsupported) != 0) record.unsupported_since_epoch = in.Number<std::uint64_t>();
  return (bits & ~kAllBits) == 0;
}

bool FitsFirstFormat(const AnchorRecord& record) {
  return !record.link && !record.expires_utc_ms && !record.unsupported_since_epoch &&
         record.visibility == AnchorVisibility::kRoom && record.editing == AnchorEditing::kEveryone;
}

std::string Encode(const AnchorState& state, std::uint8_t format) {
  Writer out;
  out.Number(format);
  out.Number(static_cast<std::uint8_t>(state.is_deleted ? kDeleted : kLive));
  out.Number(state.record.revision);
  out.Text(state.record.room.text());
  out.Text(state.record.id.text());
  if (!state.is_deleted) {
    out.Text(state.creation);
    WriteContent(out, state.record);
    if (format > kFirstFormat) WriteExtension(out, state.record);
  }
  return std::move(out).Take();
}

}  // namespace

std::string EncodeState(const AnchorState& state) { return Encode(state, kStateFormat); }

std::string EncodeForFingerprint(const AnchorState& state) {
  return Encode(state, FitsFirstFormat(state.record) ? kFirstFormat : kStateFormat);
}

Result<AnchorState> DecodeState(std::string_view bytes) {
  Reader in(bytes);
  const auto format = in.Number<std::uint8_t>();
  if (format < kFirstFormat || format > kStateFormat) {
    return MakeError(ErrorCode::kCorrupt, "state: expected format {} or {}, found {}", kFirstFormat,
                     kStateFormat, format);
  }
  const auto kind = in.Number<std::uint8_t>();
  if (kind > kDeleted) return MakeError(ErrorCode::kCorrupt, "state: found kind {}", kind);
  const auto revision = in.Number<std::uint64_t>();
  RoomId room(in.Text());
  AnchorId id(in.Text());
  AnchorState state{.record = {.id = std::move(id), .room = std::move(room), .revision = revision},
                    .creation = {},
                    .is_deleted = kind == kDeleted};
  if (!state.is_deleted) {
    state.creation = in.Text();
    ReadContent(in, state.record);
    if (format > kFirstFormat && !ReadExtension(in, state.record)) {
      return MakeError(ErrorCode::kCorrupt, "state: found unknown optional fields");
    }
  }
  if (!in.at_end()) {
    return MakeError(ErrorCode::kCorrupt, "state: {} bytes are {}", bytes.size(),
                     in.ok() ? "too many" : "too few");
  }
  if (!state.is_deleted) {
    if (const auto valid = Validate(state.record); !valid) {
      return MakeError(ErrorCode::kCorrupt, "state: {}", valid.error().message);
    }
  }
  return state;
}

}  // namespace waymark::content::internal
