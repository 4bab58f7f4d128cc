// SPDX-License-Identifier: Apache-2.0
#include "session/recording/mcap.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "session/recording/internal/mcap_file.h"

namespace waymark::session::recording {
namespace {

using Json = nlohmann::ordered_json;

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

constexpr const char* kPosesSchema = "foxglove.PosesInFrame";
constexpr const char* kSceneSchema = "foxglove.SceneUpdate";

std::string SchemaText(const char* title, const char* items) {
  return Dump({{"title", title},
               {"type", "object"},
               {"properties", {{items, {{"type", "array"}, {"items", {{"type", "object"}}}}}}}});
}

}  // namespace

McapWriter::McapWriter(std::unique_ptr<internal::McapFile> file, std::int64_t start_ns)
    : file_(std::move(file)),
      start_ns_(start_ns),
      poses_(file_->AddSchema(kPosesSchema, SchemaText(kPosesSchema, "poses"))),
      scene_(file_->AddSchema(kSceneSchema, SchemaText(kSceneSchema, "entities"))) {}

McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;
McapWriter::~McapWriter() = default;

Result<McapWriter> McapWriter::Create(const std::filesystem::path& path,
                                      const RecordingHeader& header) {
  WAYMARK_TRY_ASSIGN(internal::McapFile file, internal::McapFile::Create(path, "waymark-replay"));
  return McapWriter(std::make_unique<internal::McapFile>(std::move(file)),
                    header.started_utc_ms * 1'000'000);
}

void McapWriter::AddTo(const std::string& topic, std::uint16_t schema, ServerTime time,
                       const std::string& json) {
  auto channel = channels_.find(topic);
  if (channel == channels_.end()) {
    channel = channels_.emplace(topic, file_->AddChannel(topic, schema)).first;
  }
  const auto ns = static_cast<std::uint64_t>(start_ns_ + (time - *began_).count());
  file_->AddMessage(channel->second, ns, json);
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
      AddTo(topic(poses->room, "poses"), poses_, event.time, Dump(json));
    } else if (const auto* shown = std::get_if<effect::PublishAnchor>(&effect)) {
      AddTo(topic(shown->room, "anchors"), scene_, event.time,
            Dump({{"deletions", Json::array()},
                  {"entities", Json::array({EntityJson(shown->state.anchor, ns)})}}));
    } else if (const auto* gone = std::get_if<effect::WithdrawAnchor>(&effect)) {
      AddTo(topic(gone->room, "anchors"), scene_, event.time,
            Dump({{"deletions",
                   Json::array({Json{
                       {"timestamp", TimeJson(ns)}, {"type", 0}, {"id", gone->anchor.text()}}})},
                  {"entities", Json::array()}}));
    }
  }
}

Result<void> McapWriter::Finish() { return file_->Finish(); }

}  // namespace waymark::session::recording
