// SPDX-License-Identifier: Apache-2.0
#include "session/rehearsal/kept_query.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"

namespace waymark::session {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kFormat = "waymark-query";
constexpr int kVersion = 1;
constexpr std::size_t kMaxHeaderBytes = 4096;

json HeaderOf(const LocaliseQuery& query) {
  json header{{"format", kFormat}, {"version", kVersion}};
  header["camera"] = {{"kind", CameraKindName(query.camera.kind())},
                      {"width_px", query.camera.width_px()},
                      {"height_px", query.camera.height_px()},
                      {"parameters", query.camera.parameters()}};
  if (query.prior) {
    const GeoPoint& at = query.prior->position;
    header["prior"] = {{"latitude_deg", at.latitude.degrees()},
                       {"longitude_deg", at.longitude.degrees()},
                       {"ellipsoid_height_m", at.ellipsoid_height_m},
                       {"sigma_m", query.prior->sigma_m}};
  }
  if (query.up_in_camera) {
    const Eigen::Vector3d& up = *query.up_in_camera;
    header["up_in_camera"] = {up.x(), up.y(), up.z()};
  }
  header["image_bytes"] = query.image.size();
  header["image_xxh3"] = Checksum(query.image);
  return header;
}

/// Throws json::exception where a field is missing or of another kind.
Result<LocaliseQuery> ReadHeader(const json& header) {
  const json& camera = header.at("camera");
  const auto kind = FindCameraKind(camera.at("kind").get<std::string>());
  if (!kind) return MakeError(ErrorCode::kCorrupt, "expected a kind of camera");
  const auto parameters = camera.at("parameters").get<std::vector<double>>();
  WAYMARK_TRY_ASSIGN(const CameraModel model,
                     CameraModel::Create(*kind, camera.at("width_px").get<int>(),
                                         camera.at("height_px").get<int>(), parameters));
  LocaliseQuery query{.time = {}, .camera = model, .prior = {}, .up_in_camera = {}, .image = {}};
  if (header.contains("prior")) {
    const json& prior = header.at("prior");
    query.prior = GeoPrior{{Angle::Degrees(prior.at("latitude_deg").get<double>()),
                            Angle::Degrees(prior.at("longitude_deg").get<double>()),
                            prior.at("ellipsoid_height_m").get<double>()},
                           prior.at("sigma_m").get<double>()};
    WAYMARK_TRY(query.prior->position.Validate());
    if (!(query.prior->sigma_m >= 0)) return MakeError(ErrorCode::kCorrupt, "expected sigma >= 0");
  }
  if (header.contains("up_in_camera")) {
    const auto up = header.at("up_in_camera").get<std::array<double, 3>>();
    query.up_in_camera = Eigen::Vector3d(up[0], up[1], up[2]);
    if (!(std::abs(query.up_in_camera->norm() - 1) < 1e-3)) {
      return MakeError(ErrorCode::kCorrupt, "expected a unit vector up");
    }
  }
  return query;
}

}  // namespace

std::vector<std::uint8_t> EncodeKeptQuery(const LocaliseQuery& query) {
  const std::string header = HeaderOf(query).dump() + "\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.insert(bytes.end(), query.image.begin(), query.image.end());
  return bytes;
}

Result<LocaliseQuery> DecodeKeptQuery(std::span<const std::uint8_t> bytes, std::string_view name) {
  const auto corrupt = [&](std::string_view why) {
    return MakeError(ErrorCode::kCorrupt, "{}: no kept question: {}", name, why);
  };
  const auto end = std::ranges::find(bytes.first(std::min(bytes.size(), kMaxHeaderBytes)), '\n');
  const auto length = static_cast<std::size_t>(end - bytes.begin());
  if (length == std::min(bytes.size(), kMaxHeaderBytes)) return corrupt("expected a line of JSON");
  const auto image = bytes.subspan(length + 1);
  try {
    const json header = json::parse(bytes.begin(), end);
    if (header.at("format") != kFormat) return corrupt("it says another format");
    if (header.at("version") != kVersion) {
      return MakeError(ErrorCode::kUnsupported, "{}: expected version {}, found {}", name, kVersion,
                       header.at("version").dump());
    }
    if (header.at("image_bytes") != image.size() || image.size() > kMaxImageBytes) {
      return corrupt("its image is cut off or too large");
    }
    if (header.at("image_xxh3") != Checksum(image)) return corrupt("its checksum is wrong");
    auto query = ReadHeader(header);
    if (!query) return corrupt(query.error().message);
    query->image.assign(image.begin(), image.end());
    return query;
  } catch (const json::exception& exception) {
    return corrupt(exception.what());
  }
}

Result<std::vector<fs::path>> ListKeptQueries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    if (at->path().extension() == kKeptQueryEnding) files.push_back(at->path());
  }
  if (error) {
    return MakeError(ErrorCode::kNotFound, "{}: cannot be listed: {}", folder.string(),
                     error.message());
  }
  std::ranges::sort(files);
  return files;
}

Result<LocaliseQuery> LoadKeptQuery(const fs::path& file) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(file));
  return DecodeKeptQuery(bytes, file.string());
}

}  // namespace waymark::session
