// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/experience_index.h"

#include "mapping/base/file.h"
#include "mapping/pipeline/internal/json_decoding.h"

namespace waymark::mapping {
namespace {

using nlohmann::json;

constexpr int kFormat = 1;

json EncodeCamera(const CameraSensor& camera) {
  return {{"id", camera.id},
          {"model", CameraKindName(camera.model.kind())},
          {"width_px", camera.model.width_px()},
          {"height_px", camera.model.height_px()},
          {"parameters",
           std::vector<double>(camera.model.parameters().begin(), camera.model.parameters().end())},
          {"has_known_focal", camera.has_known_focal}};
}

json EncodeMount(const CameraMount& mount) {
  const Eigen::Quaterniond& q = mount.camera_from_rig.rotation();
  const Eigen::Vector3d& t = mount.camera_from_rig.translation();
  return {{"rig", mount.rig},
          {"camera_from_rig", {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()}}};
}

Result<CameraSensor> DecodeCamera(const json& value, std::string_view name) {
  const auto model_name = value.at("model").get<std::string>();
  const auto kind = FindCameraKind(model_name);
  if (!kind) return MakeError(ErrorCode::kCorrupt, "{}: camera model {}", name, model_name);
  const auto parameters = value.at("parameters").get<std::vector<double>>();
  auto model = CameraModel::Create(*kind, value.at("width_px").get<int>(),
                                   value.at("height_px").get<int>(), parameters);
  if (!model) return MakeError(ErrorCode::kCorrupt, "{}: {}", name, model.error().message);
  return CameraSensor{value.at("id").get<std::string>(), *model,
                      value.at("has_known_focal").get<bool>()};
}

json EncodeImage(const IndexedImage& image) {
  json value{{"name", image.name},
             {"time_ns", ToNanoseconds(image.time)},
             {"camera", image.camera},
             {"features", image.features}};
  if (image.gnss) {
    value["gnss"] = {image.gnss->latitude.degrees(), image.gnss->longitude.degrees(),
                     image.gnss->ellipsoid_height_m, image.gnss_sigma_m};
  }
  if (image.up_in_camera) {
    const Eigen::Vector3d& up = *image.up_in_camera;
    value["up_in_camera"] = {up.x(), up.y(), up.z()};
  }
  if (image.next_from_this) {
    const Eigen::Quaterniond& q = *image.next_from_this;
    value["next_from_this"] = {q.x(), q.y(), q.z(), q.w()};
  }
  return value;
}

template <std::size_t kCount>
std::array<double, kCount> Numbers(const json& value) {
  return value.get<std::array<double, kCount>>();
}

CameraMount DecodeMount(const json& value) {
  const auto p = Numbers<7>(value.at("camera_from_rig"));
  return {value.at("rig").get<std::string>(),
          Rigid3(Eigen::Quaterniond(p[3], p[0], p[1], p[2]).normalized(), {p[4], p[5], p[6]})};
}

Result<IndexedImage> DecodeImage(const json& value, const ExperienceIndex& index,
                                 std::string_view name) {
  IndexedImage image{.name = value.at("name").get<std::string>(),
                     .time = FromNanoseconds<SensorTime>(value.at("time_ns").get<std::int64_t>()),
                     .camera = value.at("camera").get<std::uint32_t>(),
                     .features = value.at("features").get<std::string>()};
  if (image.camera >= index.cameras.size()) {
    return MakeError(ErrorCode::kCorrupt, "{}: image {} names camera {} of {}", name, image.name,
                     image.camera, index.cameras.size());
  }
  if (value.contains("gnss")) {
    const auto gnss = Numbers<4>(value["gnss"]);
    image.gnss = GeoPoint{Angle::Degrees(gnss[0]), Angle::Degrees(gnss[1]), gnss[2]};
    image.gnss_sigma_m = gnss[3];
    if (!image.gnss->Validate() || !(gnss[3] > 0)) {
      return MakeError(ErrorCode::kCorrupt, "{}: position of image {}", name, image.name);
    }
  }
  if (value.contains("up_in_camera")) {
    const auto up = Numbers<3>(value["up_in_camera"]);
    image.up_in_camera = Eigen::Vector3d(up[0], up[1], up[2]);
  }
  if (value.contains("next_from_this")) {
    const auto q = Numbers<4>(value["next_from_this"]);
    image.next_from_this = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized();
  }
  return image;
}

Result<ExperienceIndex> DecodeBody(const json& body, std::string_view name) {
  ExperienceIndex index{.id = ExperienceId(body.at("id").get<std::string>()),
                        .content = body.at("content").get<std::string>(),
                        .features = body.at("features").get<std::string>()};
  for (const json& value : body.at("cameras")) {
    WAYMARK_TRY_ASSIGN(CameraSensor camera, DecodeCamera(value, name));
    index.cameras.push_back(std::move(camera));
    index.mounts.push_back(value.contains("mount") ? std::optional(DecodeMount(value["mount"]))
                                                   : std::nullopt);
  }
  for (const json& value : body.at("images")) {
    WAYMARK_TRY_ASSIGN(IndexedImage image, DecodeImage(value, index, name));
    index.images.push_back(std::move(image));
  }
  for (const json& value : body.at("unusable")) {
    index.unusable.push_back(
        {value.at("name").get<std::string>(), value.at("reason").get<std::string>()});
  }
  return index;
}

/// One element per line: such a file is read by people when something is wrong.
std::string ListLines(const std::vector<json>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i == 0 ? "\n" : ",\n") + values[i].dump();
  }
  return text + "]";
}

}  // namespace

std::string EncodeIndex(const ExperienceIndex& index) {
  std::vector<json> cameras, images, unusable;
  for (std::size_t k = 0; k < index.cameras.size(); ++k) {
    cameras.push_back(EncodeCamera(index.cameras[k]));
    if (index.mounts[k]) cameras.back()["mount"] = EncodeMount(*index.mounts[k]);
  }
  for (const IndexedImage& image : index.images) images.push_back(EncodeImage(image));
  for (const UnusableImage& image : index.unusable) {
    unusable.push_back({{"name", image.name}, {"reason", image.reason}});
  }
  return fmt::format(
      "{{\"format\": {},\n\"id\": {},\n\"content\": {},\n\"features\": {},\n"
      "\"cameras\": {},\n\"images\": {},\n\"unusable\": {}}}\n",
      kFormat, json(index.id.text()).dump(), json(index.content).dump(),
      json(index.features).dump(), ListLines(cameras), ListLines(images), ListLines(unusable));
}

Result<ExperienceIndex> DecodeIndex(std::string_view text, std::string_view name) {
  return DecodeJson<ExperienceIndex>(text, name, kFormat,
                                     [&](const json& body) { return DecodeBody(body, name); });
}

Result<ExperienceIndex> LoadIndex(const std::filesystem::path& experience_folder) {
  const std::filesystem::path path = IndexPath(experience_folder);
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(path));
  return DecodeIndex(text, path.string());
}

}  // namespace waymark::mapping
