// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/query_images.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <system_error>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"

namespace waymark::localiser::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxGnssGapS = 5;

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    std::string_view part = text.substr(begin, end - begin);
    while (!part.empty() && std::isspace(static_cast<unsigned char>(part.front()))) {
      part.remove_prefix(1);
    }
    while (!part.empty() && std::isspace(static_cast<unsigned char>(part.back()))) {
      part.remove_suffix(1);
    }
    parts.emplace_back(part);
    begin = end + 1;
  }
  return parts;
}

bool IsPhoto(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png";
}

Result<std::vector<QueryImage>> FindPhotos(const fs::path& folder,
                                           const std::optional<CameraModel>& camera) {
  std::vector<QueryImage> images;
  std::error_code error;
  fs::recursive_directory_iterator entries(folder, error);
  for (; !error && entries != fs::recursive_directory_iterator(); entries.increment(error)) {
    const fs::path& path = entries->path();
    std::error_code ignored;
    if (!entries->is_regular_file(ignored) || !IsPhoto(path)) continue;
    images.push_back({path.lexically_relative(folder).generic_string(), path, camera, {}});
  }
  if (error) {
    return MakeError(ErrorCode::kNotFound, "{}: expected a folder of images: {}", folder.string(),
                     error.message());
  }
  std::sort(images.begin(), images.end(),
            [](const QueryImage& a, const QueryImage& b) { return a.name < b.name; });
  return images;
}

Result<std::vector<QueryImage>> FindKaptureImages(const fs::path& folder,
                                                  const std::optional<CameraModel>& camera) {
  WAYMARK_TRY_ASSIGN(const mapping::Experience experience, mapping::LoadKapture(folder));
  std::vector<QueryImage> images;
  for (const mapping::ImageRecord& image : experience.images) {
    images.push_back({image.name, experience.ImagePath(image),
                      camera ? *camera : experience.cameras.at(image.camera).model,
                      GnssAt(experience, image.time)});
  }
  return images;
}

}  // namespace

Result<std::vector<QueryImage>> FindQueryImages(const fs::path& folder,
                                                const std::optional<CameraModel>& camera) {
  std::error_code ignored;
  const bool is_kapture = fs::exists(folder / "sensors" / "sensors.txt", ignored);
  WAYMARK_TRY_ASSIGN(auto images,
                     is_kapture ? FindKaptureImages(folder, camera) : FindPhotos(folder, camera));
  if (images.empty()) {
    return MakeError(ErrorCode::kNotFound, "{}: expected JPEG or PNG images, found none",
                     folder.string());
  }
  return images;
}

Result<std::vector<QueryImage>> SelectListed(std::span<const QueryImage> images,
                                             const fs::path& list) {
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(list));
  std::map<std::string_view, const QueryImage*> by_name;
  for (const QueryImage& image : images) by_name.emplace(image.name, &image);
  std::vector<QueryImage> selected;
  for (const std::string& name : Split(text, '\n')) {
    if (name.empty()) continue;
    const auto found = by_name.find(name);
    if (found == by_name.end()) {
      return MakeError(ErrorCode::kNotFound, "{}: image {} is not among the {} of the query",
                       list.string(), name, images.size());
    }
    selected.push_back(*found->second);
  }
  return selected;
}

std::optional<GnssPlace> GnssAt(const mapping::Experience& experience, SensorTime time) {
  const auto& records = experience.gnss;
  const auto after = std::lower_bound(
      records.begin(), records.end(), time,
      [](const mapping::GnssRecord& record, SensorTime t) { return record.time < t; });
  const auto gap_s = [&](const mapping::GnssRecord& record) {
    return std::abs(Seconds(record.time - time));
  };
  const bool has_after = after != records.end() && gap_s(*after) <= kMaxGnssGapS;
  const bool has_before = after != records.begin() && gap_s(*(after - 1)) <= kMaxGnssGapS;
  if (!has_after && !has_before) return std::nullopt;
  if (!has_after) return GnssPlace{(after - 1)->place, (after - 1)->sigma_m};
  if (!has_before) return GnssPlace{after->place, after->sigma_m};
  const mapping::GnssRecord& a = *(after - 1);
  const mapping::GnssRecord& b = *after;
  const double share = gap_s(a) / std::max(1e-9, gap_s(a) + gap_s(b));
  const auto between = [&](Angle from, Angle to) {
    return from + share * (to - from).Normalized();  // the short way across the date line
  };
  return GnssPlace{{.latitude = between(a.place.latitude, b.place.latitude),
                    .longitude = between(a.place.longitude, b.place.longitude).Normalized(),
                    .ellipsoid_height_m = (1 - share) * a.place.ellipsoid_height_m +
                                          share * b.place.ellipsoid_height_m},
                   std::max(a.sigma_m, b.sigma_m)};
}

Result<CameraModel> ParseCamera(std::string_view text) {
  const std::vector<std::string> parts = Split(text, ',');
  const auto kind = FindCameraKind(parts[0]);
  std::vector<double> numbers;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    double number = 0;
    const char* end = parts[i].data() + parts[i].size();
    const auto read = std::from_chars(parts[i].data(), end, number);
    if (read.ec != std::errc() || read.ptr != end) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "camera \"{}\": expected a number, found \"{}\"", text, parts[i]);
    }
    numbers.push_back(number);
  }
  if (!kind || numbers.size() < 2 || numbers[0] > 1e6 || numbers[1] > 1e6) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "camera \"{}\": expected KIND,width,height,parameters such as "
                     "PINHOLE,640,480,520,520,320,240",
                     text);
  }
  return CameraModel::Create(*kind, static_cast<int>(numbers[0]), static_cast<int>(numbers[1]),
                             std::span(numbers).subspan(2));
}

Result<CameraModel> GuessCamera(const mapping::GrayImage& image) {
  const double focal_px = 1.2 * std::max(image.width_px, image.height_px);
  return CameraModel::Create(
      CameraKind::kSimplePinhole, image.width_px, image.height_px,
      std::vector<double>{focal_px, image.width_px / 2.0, image.height_px / 2.0});
}

}  // namespace waymark::localiser::internal
