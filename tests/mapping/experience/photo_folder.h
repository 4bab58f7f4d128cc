// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <exiv2/exiv2.hpp>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/experience/import_photos.h"

namespace waymark::mapping {

using Tags = std::map<std::string, std::string>;

/// The markers of a JPEG of this size, around no picture at all.
inline std::vector<std::uint8_t> EmptyJpeg(int width_px, int height_px) {
  const auto high = [](int v) { return static_cast<std::uint8_t>(v >> 8); };
  const auto low = [](int v) { return static_cast<std::uint8_t>(v & 0xFF); };
  // clang-format off
  return {0xFF, 0xD8,                                                    // start of image
          0xFF, 0xC0, 0, 11, 8, high(height_px), low(height_px),         // frame
          high(width_px), low(width_px), 1, 1, 0x11, 0,
          0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0, 0x12, 0xFF, 0x00, 0x34,   // scan
          0xFF, 0xD9};                                                   // end of image
  // clang-format on
}

inline const Tags kFullTags{{"Exif.Image.Make", "Acme"},
                            {"Exif.Image.Model", "One"},
                            {"Exif.Photo.DateTimeOriginal", "2024:05:01 12:30:15"},
                            {"Exif.Photo.SubSecTimeOriginal", "25"},
                            {"Exif.Photo.FocalLengthIn35mmFilm", "28"},
                            {"Exif.GPSInfo.GPSLatitudeRef", "S"},
                            {"Exif.GPSInfo.GPSLatitude", "33/1 51/1 3030/100"},
                            {"Exif.GPSInfo.GPSLongitudeRef", "W"},
                            {"Exif.GPSInfo.GPSLongitude", "70/1 30/1 0/1"},
                            {"Exif.GPSInfo.GPSAltitude", "125/10"},
                            {"Exif.GPSInfo.GPSAltitudeRef", "1"},
                            {"Exif.GPSInfo.GPSDOP", "3/1"}};

/// A folder of photos that a test makes, and what becomes of it.
class ImportedPhotos : public testing::Test {
 protected:
  void SetUp() override {
    root_ =
        std::filesystem::path(testing::TempDir()) /
        (std::string("photos.") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_ / "photos" / "day");
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  void Write(const std::string& name, std::span<const std::uint8_t> bytes) const {
    ASSERT_TRUE(StoreFileAtomically(root_ / "photos" / name, bytes));
  }
  void WritePhoto(const std::string& name, const Tags& tags, int width_px = 400,
                  int height_px = 300) const {
    Write(name, EmptyJpeg(width_px, height_px));
    auto image = Exiv2::ImageFactory::open((root_ / "photos" / name).string());
    Exiv2::ExifData exif;
    for (const auto& [key, value] : tags) exif[key] = value;
    image->setExifData(exif);
    image->writeMetadata();
  }
  Result<PhotoImport> Import() const { return ImportPhotos(root_ / "photos", root_ / "walk"); }

  static Tags With(const std::string& key, const std::string& value) {
    Tags tags = kFullTags;
    tags[key] = value;
    return tags;
  }
  static Tags Without(const std::string& key) {
    Tags tags = kFullTags;
    tags.erase(key);
    return tags;
  }

  std::filesystem::path root_;
};

}  // namespace waymark::mapping
