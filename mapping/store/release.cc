// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/release.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/io/stored_rotation.h"
#include "mapping/store/internal/json_reader.h"

namespace waymark::mapping {
namespace {

using internal::Json;
using internal::JsonReader;

Json EncodeVector(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json EncodeSimilarity(const Sim3& sim) {
  const Eigen::Quaterniond q = StoredRotation(sim.rotation());
  return Json{{"scale", sim.scale()},
              {"rotation_xyzw", Json::array({q.x(), q.y(), q.z(), q.w()})},
              {"translation_m", EncodeVector(sim.translation())}};
}

Json EncodeDisplacement(const std::optional<Displacement>& displacement) {
  if (!displacement) return nullptr;
  return Json{{"translation_m", displacement->translation_m},
              {"rotation_rad", displacement->rotation_rad},
              {"scale_ratio", displacement->scale_ratio}};
}

Json EncodeReleasedSubmap(const ReleasedSubmap& submap) {
  return Json{{"id", submap.id.text()},
              {"map_from_submap", EncodeSimilarity(submap.map_from_submap.sim())},
              {"centre_in_map_m", EncodeVector(submap.centre.coordinates())},
              {"radius_m", submap.radius_m},
              {"overlap_rms_m", submap.overlap_rms_m},
              {"gnss_rms_m", submap.gnss_rms_m},
              {"displacement", EncodeDisplacement(submap.displacement)}};
}

Result<double> DecodeNumber(const JsonReader& object, std::string_view key, double least) {
  WAYMARK_TRY_ASSIGN(const auto member, object.Member(key));
  return member.NumberAtLeast(least);
}

/// A ratio of lengths: above 0 and far from what no map can be.
Result<double> DecodeScale(const JsonReader& object, std::string_view key) {
  WAYMARK_TRY_ASSIGN(const auto member, object.Member(key));
  WAYMARK_TRY_ASSIGN(const double scale, member.Number());
  if (!(scale > 1e-6 && scale < 1e6)) return member.Wrong("a scale between 1e-6 and 1e6");
  return scale;
}

template <int kSize>
Result<Eigen::Matrix<double, kSize, 1>> DecodeVector(const JsonReader& object,
                                                     std::string_view key) {
  WAYMARK_TRY_ASSIGN(const auto member, object.Member(key));
  WAYMARK_TRY_ASSIGN(const auto elements, member.Elements());
  if (elements.size() != kSize) return member.Wrong(fmt::format("{} numbers", kSize));
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = 0; i < kSize; ++i) {
    WAYMARK_TRY_ASSIGN(vector[i], elements[static_cast<std::size_t>(i)].Number());
  }
  return vector;
}

Result<Similarity<Map, Submap>> DecodeSimilarity(const JsonReader& object) {
  WAYMARK_TRY_ASSIGN(const double scale, DecodeScale(object, "scale"));
  WAYMARK_TRY_ASSIGN(const auto xyzw, DecodeVector<4>(object, "rotation_xyzw"));
  WAYMARK_TRY_ASSIGN(const auto translation, DecodeVector<3>(object, "translation_m"));
  if (!(std::abs(xyzw.norm() - 1) < 1e-9)) {
    return object.Wrong("rotation_xyzw as a unit quaternion");
  }
  return Similarity<Map, Submap>(Sim3(scale, Eigen::Quaterniond(xyzw), translation));
}

Result<std::optional<Displacement>> DecodeDisplacement(const JsonReader& value) {
  if (value.IsNull()) return std::optional<Displacement>();
  Displacement displacement;
  WAYMARK_TRY_ASSIGN(displacement.translation_m, DecodeNumber(value, "translation_m", 0));
  WAYMARK_TRY_ASSIGN(displacement.rotation_rad, DecodeNumber(value, "rotation_rad", 0));
  WAYMARK_TRY_ASSIGN(displacement.scale_ratio, DecodeScale(value, "scale_ratio"));
  return std::optional(displacement);
}

Result<SubmapId> DecodeSubmapId(const JsonReader& object) {
  WAYMARK_TRY_ASSIGN(const auto member, object.Member("id"));
  WAYMARK_TRY_ASSIGN(std::string text, member.Text());
  if (!IsSubmapIdText(text)) return member.Wrong("a content hash of 32 hexadecimal digits");
  return SubmapId(std::move(text));
}

Result<ReleasedSubmap> DecodeReleasedSubmap(const JsonReader& object) {
  WAYMARK_TRY_ASSIGN(SubmapId id, DecodeSubmapId(object));
  WAYMARK_TRY_ASSIGN(const auto similarity, object.Member("map_from_submap"));
  WAYMARK_TRY_ASSIGN(const auto map_from_submap, DecodeSimilarity(similarity));
  WAYMARK_TRY_ASSIGN(const Eigen::Vector3d centre, DecodeVector<3>(object, "centre_in_map_m"));
  WAYMARK_TRY_ASSIGN(const double radius_m, DecodeNumber(object, "radius_m", 0));
  WAYMARK_TRY_ASSIGN(const double overlap_rms_m, DecodeNumber(object, "overlap_rms_m", 0));
  WAYMARK_TRY_ASSIGN(const double gnss_rms_m, DecodeNumber(object, "gnss_rms_m", 0));
  WAYMARK_TRY_ASSIGN(const auto displaced, object.Member("displacement"));
  WAYMARK_TRY_ASSIGN(const auto displacement, DecodeDisplacement(displaced));
  return ReleasedSubmap{std::move(id), map_from_submap, Point<Map>(centre), radius_m,
                        overlap_rms_m, gnss_rms_m,      displacement};
}

Result<std::optional<std::uint64_t>> DecodeParent(const JsonReader& root, std::uint64_t epoch) {
  WAYMARK_TRY_ASSIGN(const auto member, root.Member("parent_epoch"));
  if (member.IsNull()) return std::optional<std::uint64_t>();
  WAYMARK_TRY_ASSIGN(const std::uint64_t parent, member.Unsigned());
  if (parent < 1 || parent >= epoch) return member.Wrong(fmt::format("an epoch below {}", epoch));
  return std::optional(parent);
}

Result<std::vector<ReleasedSubmap>> DecodeSubmaps(const JsonReader& root) {
  WAYMARK_TRY_ASSIGN(const auto member, root.Member("submaps"));
  WAYMARK_TRY_ASSIGN(const auto elements, member.Elements());
  std::vector<ReleasedSubmap> submaps;
  for (const JsonReader& element : elements) {
    WAYMARK_TRY_ASSIGN(ReleasedSubmap submap, DecodeReleasedSubmap(element));
    if (!submaps.empty() && submap.id <= submaps.back().id) {
      return element.Wrong("submaps sorted by id, each once");
    }
    submaps.push_back(std::move(submap));
  }
  return submaps;
}

/// Absent in releases of earlier versions.
Result<std::optional<double>> DecodeFusionTime(const JsonReader& root) {
  if (!root.json().contains("fusion_s")) return std::optional<double>();
  WAYMARK_TRY_ASSIGN(const double seconds, DecodeNumber(root, "fusion_s", 0));
  return std::optional(seconds);
}

}  // namespace

bool IsSubmapIdText(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string EncodeRelease(const Release& release) {
  Json submaps = Json::array();
  for (const ReleasedSubmap& submap : release.submaps) {
    submaps.push_back(EncodeReleasedSubmap(submap));
  }
  const Json parent = release.parent_epoch ? Json(*release.parent_epoch) : Json(nullptr);
  Json document{{"format_version", internal::kMapFormatVersion},
                {"epoch", release.epoch},
                {"parent_epoch", parent},
                {"created_utc", release.created_utc},
                {"submaps", std::move(submaps)}};
  if (release.fusion_s) document["fusion_s"] = *release.fusion_s;
  return internal::DumpDocument(document);
}

Result<Release> DecodeRelease(std::string_view json, std::string_view name) {
  WAYMARK_TRY_ASSIGN(const Json document, internal::ParseDocument(json, name));
  const JsonReader root(document, fmt::format("{}: ", name));
  Release release;
  WAYMARK_TRY_ASSIGN(const auto epoch, root.Member("epoch"));
  WAYMARK_TRY_ASSIGN(release.epoch, epoch.Unsigned());
  if (release.epoch < 1) return epoch.Wrong("an epoch of at least 1");
  WAYMARK_TRY_ASSIGN(release.parent_epoch, DecodeParent(root, release.epoch));
  WAYMARK_TRY_ASSIGN(const auto created, root.Member("created_utc"));
  WAYMARK_TRY_ASSIGN(release.created_utc, created.Text());
  WAYMARK_TRY_ASSIGN(release.submaps, DecodeSubmaps(root));
  WAYMARK_TRY_ASSIGN(release.fusion_s, DecodeFusionTime(root));
  return release;
}

}  // namespace waymark::mapping
