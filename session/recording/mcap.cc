// SPDX-License-Identifier: Apache-2.0
#include "session/recording/mcap.h"

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

namespace waymark::session::recording {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
enum Kind : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kDataEnd = 15,
};
constexpr std::uint16_t kPoses = 1, kScene = 2;  // schemas

/// A record's fields, little-endian.
class Fields {
 public:
  template <typename T>
  Fields& Add(T number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  Fields& AddText(std::string_view text) {
    Add(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  Fields& AddRest(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

template <typename To, typename From>
Json PoseJson(const Transform<To, From>& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond& q = pose.rotation();
  return {{"position", {{"x", t.x()}, {"y", t.y()}, {"z", t.z()}}},
          {"orientation", {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}}};
}

Json TimeJson(std::int64_t ns) {
  return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}};
}

std::string Dump(const Json& json) {
  // Payloads and names are anybody's: what is no UTF-8 must not throw.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json EntityJson(const RoomAnchor& anchor, std::int64_t ns) {
  constexpr double kSide_m = 0.2;
  const Json pose = PoseJson(anchor.record.map_from_anchor);
  const double blue = anchor.is_supported ? 1.0 : 0.2;
  return {{"timestamp", TimeJson(ns)},
          {"frame_id", "map"},
          {"id", anchor.record.id.text()},
          {"lifetime", TimeJson(0)},
          {"frame_locked", false},
          {"metadata", Json::array({Json{{"key", "kind"}, {"value", anchor.record.kind}},
                                    Json{{"key", "owner"}, {"value", anchor.record.owner}}})},
          {"cubes", Json::array({Json{{"pose", pose},
                                      {"size", {{"x", kSide_m}, {"y", kSide_m}, {"z", kSide_m}}},
                                      {"color", {{"r", 1}, {"g", 0.6}, {"b", blue}, {"a", 1}}}}})}};
}

std::string SchemaText(const char* title, const char* items) {
  return Dump({{"title", title},
               {"type", "object"},
               {"properties", {{items, {{"type", "array"}, {"items", {{"type", "object"}}}}}}}});
}

}  // namespace

Result<McapWriter> McapWriter::Create(const std::filesystem::path& path,
                                      const RecordingHeader& header) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    return MakeError(ErrorCode::kUnavailable, "{}: {}", path.string(), std::strerror(errno));
  }
  McapWriter writer(path, file, header.started_utc_ms * 1'000'000);
  (void)std::fwrite(kMagic.data(), 1, kMagic.size(), file);
  writer.Put(kHeader, Fields().AddText("").AddText("waymark-replay").bytes());
  const auto add_schema = [&](std::uint16_t number, const char* name, const char* items) {
    writer.Put(kSchema, Fields()
                            .Add(number)
                            .AddText(name)
                            .AddText("jsonschema")
                            .AddText(SchemaText(name, items))
                            .bytes());
  };
  add_schema(kPoses, "foxglove.PosesInFrame", "poses");
  add_schema(kScene, "foxglove.SceneUpdate", "entities");
  return writer;
}

void McapWriter::Put(std::uint8_t kind, std::string_view content) {
  const std::string head = Fields().Add(kind).Add(std::uint64_t{content.size()}).bytes();
  (void)std::fwrite(head.data(), 1, head.size(), file_.get());
  (void)std::fwrite(content.data(), 1, content.size(), file_.get());
}

std::uint16_t McapWriter::ChannelOf(const std::string& topic, std::uint16_t schema) {
  const auto [channel, is_new] =
      channels_.try_emplace(topic, static_cast<std::uint16_t>(channels_.size() + 1));
  if (is_new) {
    Put(kChannel, Fields()
                      .Add(channel->second)
                      .Add(schema)
                      .AddText(topic)
                      .AddText("json")
                      .Add(std::uint32_t{0})  // no metadata
                      .bytes());
  }
  return channel->second;
}

void McapWriter::AddTo(const std::string& topic, std::uint16_t schema, ServerTime time,
                       const std::string& json) {
  const std::uint16_t channel = ChannelOf(topic, schema);
  const auto ns = static_cast<std::uint64_t>(start_ns_ + (time - *began_).count());
  Put(kMessage, Fields().Add(channel).Add(sequence_++).Add(ns).Add(ns).AddRest(json).bytes());
}

void McapWriter::Add(const RecordedEvent& event, std::span<const Effect> effects) {
  if (!began_) began_ = event.time;
  const std::int64_t ns = start_ns_ + (event.time - *began_).count();
  const auto topic = [](const RoomId& room, const char* what) {
    return "/rooms/" + room.text() + "/" + what;
  };
  for (const Effect& effect : effects) {
    if (const auto* poses = std::get_if<effect::PublishPoses>(&effect)) {
      Json json{{"timestamp", TimeJson(ns)}, {"frame_id", "map"}, {"poses", Json::array()}};
      for (const SharedPose& shared : poses->poses) {
        json["poses"].push_back(PoseJson(shared.pose.map_from_device));
      }
      AddTo(topic(poses->room, "poses"), kPoses, event.time, Dump(json));
    } else if (const auto* shown = std::get_if<effect::PublishAnchor>(&effect)) {
      AddTo(topic(shown->room, "anchors"), kScene, event.time,
            Dump({{"deletions", Json::array()},
                  {"entities", Json::array({EntityJson(shown->state.anchor, ns)})}}));
    } else if (const auto* gone = std::get_if<effect::WithdrawAnchor>(&effect)) {
      AddTo(topic(gone->room, "anchors"), kScene, event.time,
            Dump({{"deletions",
                   Json::array({Json{
                       {"timestamp", TimeJson(ns)}, {"type", 0}, {"id", gone->anchor.text()}}})},
                  {"entities", Json::array()}}));
    }
  }
}

Result<void> McapWriter::Finish() {
  Put(kDataEnd, Fields().Add(std::uint32_t{0}).bytes());  // no checksum
  Put(kFooter, Fields().Add(std::uint64_t{0}).Add(std::uint64_t{0}).Add(std::uint32_t{0}).bytes());
  (void)std::fwrite(kMagic.data(), 1, kMagic.size(), file_.get());
  const bool is_written = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  if (is_written) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: could not be written: {}", path_.string(),
                   std::strerror(errno));
}

}  // namespace waymark::session::recording
