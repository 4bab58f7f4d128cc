// SPDX-License-Identifier: Apache-2.0
// What a photo says about itself: the markers of JPEG, and EXIF.
#include <cmath>
#include <exiv2/exiv2.hpp>
#include <map>

#include "mapping/base/check.h"
#include "mapping/experience/internal/jpeg_structure.h"
#include "mapping/experience/internal/photo_exif.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/mapping/experience/photo_folder.h"

namespace waymark::fuzz {
namespace {

Bytes Photo(const mapping::Tags& tags) {
  const Bytes empty = mapping::EmptyJpeg(400, 300);
  const auto image = Exiv2::ImageFactory::open(empty.data(), static_cast<long>(empty.size()));
  Exiv2::ExifData exif;
  for (const auto& [key, value] : tags) exif[key] = value;
  image->setExifData(exif);
  image->writeMetadata();
  Exiv2::BasicIo& io = image->io();
  const Exiv2::byte* begin = io.mmap();
  return {begin, begin + io.size()};
}

}  // namespace

std::vector<Bytes> Seeds() {
  mapping::Tags lens{{"Exif.Photo.FocalLength", "42/10"},
                     {"Exif.Photo.FocalPlaneXResolution", "3000/1"},
                     {"Exif.Photo.FocalPlaneResolutionUnit", "3"},
                     {"Exif.Photo.PixelXDimension", "400"},
                     {"Exif.GPSInfo.GPSDateStamp", "2024:05:01"},
                     {"Exif.GPSInfo.GPSTimeStamp", "10/1 11/1 12/1"}};
  return {Photo(mapping::kFullTags), Photo(lens), mapping::EmptyJpeg(1, 1)};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  if (const auto size = mapping::internal::ReadJpegSize(bytes)) {
    CHECK(size->width_px > 0 && size->height_px > 0, "a photo of {} x {}", size->width_px,
          size->height_px);
  }
  const auto exif = mapping::internal::ReadPhotoExif(bytes);
  if (!exif) return;
  if (exif->place) {
    CHECK(std::abs(exif->place->latitude.degrees()) <= 90, "a latitude of {} degrees",
          exif->place->latitude.degrees());
  }
  if (exif->sigma_m) CHECK(*exif->sigma_m > 0, "sigma of {} m", *exif->sigma_m);
}

}  // namespace waymark::fuzz
