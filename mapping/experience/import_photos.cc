// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/import_photos.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>
#include <tuple>

#include "mapping/base/file.h"
#include "mapping/experience/internal/imported_folder.h"
#include "mapping/experience/internal/jpeg_structure.h"
#include "mapping/experience/internal/kapture_sensors.h"
#include "mapping/experience/internal/photo_exif.h"
#include "mapping/experience/kapture.h"
#include "mapping/experience/names.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

constexpr double kUnknownSigmaM = 5;  // as LoadKapture
constexpr std::int64_t kMaxPixels = 100'000'000;

struct Photo {
  std::string name;
  internal::JpegSize size;
  internal::PhotoExif exif;
};

enum class FileKind { kPhoto, kOtherImage, kOther };

FileKind KindOf(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".jpg" || extension == ".jpeg") return FileKind::kPhoto;
  constexpr std::array<std::string_view, 9> kOthers{".png",  ".heic", ".heif", ".tif", ".tiff",
                                                    ".webp", ".dng",  ".gif",  ".bmp"};
  const bool is_image = std::find(kOthers.begin(), kOthers.end(), extension) != kOthers.end();
  return is_image ? FileKind::kOtherImage : FileKind::kOther;
}

/// Names of all files below a folder, sorted; linked folders are not entered.
Result<std::vector<std::string>> ListFiles(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code failure;
  auto entry = fs::recursive_directory_iterator(folder, failure);
  for (; !failure && entry != fs::recursive_directory_iterator(); entry.increment(failure)) {
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    names.push_back(entry->path().lexically_relative(folder).generic_string());
  }
  if (failure) {
    return MakeError(ErrorCode::kNotFound, "{}: expected a folder of photos: {}", folder.string(),
                     failure.message());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The error's message is the reason why a photo is left out.
Result<Photo> LoadPhoto(const fs::path& folder, const std::string& name) {
  if (!IsImageName(name) || name.find(',') != std::string::npos) {
    return Error{ErrorCode::kUnsupported, "has a name that kapture cannot spell"};
  }
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(folder / name));
  WAYMARK_TRY_ASSIGN(const auto size, internal::ReadJpegSize(bytes));
  if (std::int64_t{size.width_px} * size.height_px > kMaxPixels) {
    return Error{ErrorCode::kUnsupported, "has more than 100 megapixels"};
  }
  WAYMARK_TRY_ASSIGN(auto exif, internal::ReadPhotoExif(bytes));
  return Photo{name, size, std::move(exif)};
}

Result<std::vector<Photo>> LoadPhotos(const fs::path& folder, std::vector<LeftOutPhoto>& left_out) {
  WAYMARK_TRY_ASSIGN(const auto names, ListFiles(folder));
  std::vector<Photo> photos;
  for (const std::string& name : names) {
    const FileKind kind = KindOf(name);
    if (kind == FileKind::kOther) continue;
    auto photo = kind == FileKind::kPhoto
                     ? LoadPhoto(folder, name)
                     : Result<Photo>(Error{ErrorCode::kUnsupported, "is no JPEG"});
    if (photo) {
      photos.push_back(*std::move(photo));
    } else {
      left_out.push_back({name, photo.error().message});
    }
  }
  if (!photos.empty()) return photos;
  return MakeError(
      ErrorCode::kNotFound, "{}: expected JPEG photos with EXIF, found none{}", folder.string(),
      left_out.empty()
          ? std::string()
          : fmt::format(" ({} {}, for example)", left_out[0].name, left_out[0].reason));
}

/// One instant per photo, no two alike: times of photos taken in the same second move apart.
std::vector<SensorTime> AssignTimes(const std::vector<Photo>& photos, PhotoTimes source) {
  using namespace std::chrono_literals;
  std::set<SensorTime> taken;
  std::vector<SensorTime> times;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    SensorTime time = source == PhotoTimes::kCaptured
                          ? *photos[i].exif.time
                          : SensorTime(std::chrono::seconds(static_cast<std::int64_t>(i)));
    while (!taken.insert(time).second) time += 1ms;
    times.push_back(time);
  }
  return times;
}

Result<CameraSensor> MakeCamera(std::string id, const internal::JpegSize& size,
                                std::optional<double> focal_px) {
  WAYMARK_TRY_ASSIGN(const CameraModel guess,
                     internal::GuessCameraModel(size.width_px, size.height_px));
  if (!focal_px) return CameraSensor{std::move(id), guess, false};
  const std::array<double, 4> parameters{*focal_px, size.width_px / 2.0, size.height_px / 2.0, 0};
  WAYMARK_TRY_ASSIGN(const CameraModel model,
                     CameraModel::Create(guess.kind(), size.width_px, size.height_px, parameters));
  return CameraSensor{std::move(id), model, true};
}

/// Fills cameras, images and GNSS records.
Result<void> Describe(const std::vector<Photo>& photos, PhotoImport& import) {
  const bool all_timed = std::all_of(photos.begin(), photos.end(),
                                     [](const Photo& p) { return p.exif.time.has_value(); });
  import.times = all_timed ? PhotoTimes::kCaptured : PhotoTimes::kInvented;
  const auto times = AssignTimes(photos, import.times);
  using CameraKey = std::tuple<std::string, std::string, int, int, std::optional<double>>;
  std::map<CameraKey, std::string> camera_ids;
  Experience& experience = import.experience;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const auto& [name, size, exif] = photos[i];
    const auto focal_px = internal::FindFocalPx(exif.lens, size.width_px, size.height_px);
    const auto [entry, is_new] = camera_ids.emplace(
        CameraKey{exif.make, exif.model, size.width_px, size.height_px, focal_px},
        fmt::format("cam{}", camera_ids.size()));
    if (is_new) {
      WAYMARK_TRY_ASSIGN(CameraSensor camera, MakeCamera(entry->second, size, focal_px));
      experience.cameras.emplace(entry->second, std::move(camera));
    }
    experience.images.push_back({times[i], entry->second, name});
    import.photos_with_guessed_focal += focal_px ? 0 : 1;
    import.photos_without_gps += exif.place ? 0 : 1;
    if (!exif.place) continue;
    experience.gnss.push_back(
        {times[i], "gps0", *exif.place, exif.sigma_m.value_or(kUnknownSigmaM)});
  }
  return {};
}

}  // namespace

Result<PhotoImport> ImportPhotos(const fs::path& photo_folder, const fs::path& experience_folder) {
  WAYMARK_TRY(internal::CheckImportFolders(photo_folder, experience_folder));
  PhotoImport import{.experience = {.id = ExperienceId("import"), .folder = experience_folder}};
  WAYMARK_TRY_ASSIGN(const auto photos, LoadPhotos(photo_folder, import.left_out));
  WAYMARK_TRY(Describe(photos, import));
  for (const Photo& photo : photos) {
    WAYMARK_TRY(internal::PlaceImage(photo_folder / photo.name, experience_folder, photo.name));
  }
  WAYMARK_TRY(StoreKapture(import.experience, experience_folder));
  WAYMARK_TRY_ASSIGN(import.experience, LoadKapture(experience_folder));
  return import;
}

}  // namespace waymark::mapping
