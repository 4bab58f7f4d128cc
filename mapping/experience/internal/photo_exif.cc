// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/photo_exif.h"

#include <charconv>
#include <chrono>
#include <cmath>

#include <exiv2/exiv2.hpp>

#include "mapping/experience/names.h"

namespace waymark::mapping::internal {
namespace {

const Exiv2::Exifdatum* Find(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  return found == exif.end() ? nullptr : &*found;
}

/// Component `index` of a numeric tag as a finite number.
std::optional<double> FindNumber(const Exiv2::ExifData& exif, const char* key, long index = 0) {
  const auto* tag = Find(exif, key);
  if (tag == nullptr || tag->count() <= index) return std::nullopt;
  const auto [numerator, denominator] = tag->toRational(index);
  if (denominator == 0) return std::nullopt;
  return static_cast<double>(numerator) / static_cast<double>(denominator);
}

std::optional<double> FindPositive(const Exiv2::ExifData& exif, const char* key) {
  const auto number = FindNumber(exif, key);
  return number && *number > 0 ? number : std::nullopt;
}

/// A text tag without the blanks and zeros that cameras pad it with; empty when absent.
std::string FindText(const Exiv2::ExifData& exif, const char* key) {
  const auto* tag = Find(exif, key);
  if (tag == nullptr) return {};
  std::string text = tag->toString();
  text.erase(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
  return IsPrintableText(text) && text.size() <= 200 ? text : std::string();
}

std::optional<double> FindSensorWidthMm(const Exiv2::ExifData& exif) {
  const auto pixels_per_unit = FindPositive(exif, "Exif.Photo.FocalPlaneXResolution");
  const auto width_px = FindPositive(exif, "Exif.Photo.PixelXDimension");
  const auto height_px = FindPositive(exif, "Exif.Photo.PixelYDimension");
  const auto unit = FindNumber(exif, "Exif.Photo.FocalPlaneResolutionUnit").value_or(2);
  if (!pixels_per_unit || !width_px || !height_px) return std::nullopt;
  const double unit_mm = unit == 3 ? 10 : unit == 4 ? 1 : unit == 5 ? 0.001 : 25.4;
  return std::max(*width_px, *height_px) / *pixels_per_unit * unit_mm;
}

/// Reads a whole number of a fixed count of digits.
std::optional<int> ParseDigits(std::string_view text, std::size_t first, std::size_t count) {
  if (text.size() < first + count) return std::nullopt;
  const char* begin = text.data() + first;
  int value = 0;
  const auto [end, failure] = std::from_chars(begin, begin + count, value);
  if (failure != std::errc() || end != begin + count || value < 0) return std::nullopt;
  return value;
}

std::optional<std::chrono::sys_days> ParseDate(std::string_view text) {
  const auto year = ParseDigits(text, 0, 4);
  const auto month = ParseDigits(text, 5, 2);
  const auto day = ParseDigits(text, 8, 2);
  if (!year || !month || !day || *year < 1970 || *year > 2100) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

/// An instant of a day; seconds in [0, 86,400].
std::optional<SensorTime> MakeTime(const std::optional<std::chrono::sys_days>& date,
                                   std::optional<double> seconds) {
  if (!date || !seconds || !(*seconds >= 0 && *seconds <= 86400)) return std::nullopt;
  const auto nanoseconds = std::chrono::nanoseconds(std::llround(*seconds * 1e3) * 1'000'000);
  return SensorTime(date->time_since_epoch() + nanoseconds);
}

/// "YYYY:MM:DD HH:MM:SS", fractions of a second in a tag of their own.
std::optional<SensorTime> FindCaptureTime(const Exiv2::ExifData& exif) {
  const std::string text = FindText(exif, "Exif.Photo.DateTimeOriginal");
  const auto hour = ParseDigits(text, 11, 2);
  const auto minute = ParseDigits(text, 14, 2);
  const auto second = ParseDigits(text, 17, 2);
  if (!hour || !minute || !second) return std::nullopt;
  const std::string digits = FindText(exif, "Exif.Photo.SubSecTimeOriginal").substr(0, 6);
  const auto fraction = ParseDigits(digits, 0, digits.size());
  const double part = digits.empty() || !fraction
                          ? 0
                          : *fraction / std::pow(10.0, static_cast<double>(digits.size()));
  return MakeTime(ParseDate(text), *hour * 3600 + *minute * 60 + *second + part);
}

std::optional<SensorTime> FindGpsTime(const Exiv2::ExifData& exif) {
  const auto hour = FindNumber(exif, "Exif.GPSInfo.GPSTimeStamp", 0);
  const auto minute = FindNumber(exif, "Exif.GPSInfo.GPSTimeStamp", 1);
  const auto second = FindNumber(exif, "Exif.GPSInfo.GPSTimeStamp", 2);
  if (!hour || !minute || !second) return std::nullopt;
  return MakeTime(ParseDate(FindText(exif, "Exif.GPSInfo.GPSDateStamp")),
                  *hour * 3600 + *minute * 60 + *second);
}

/// Degrees, minutes and seconds, negative for the second of two references such as "N" and "S".
std::optional<Angle> FindAngle(const Exiv2::ExifData& exif, const char* key, const char* ref_key,
                               std::string_view references) {
  const auto degrees = FindNumber(exif, key, 0);
  const std::string reference = FindText(exif, ref_key);
  if (!degrees || reference.size() != 1) return std::nullopt;
  const std::size_t sign = references.find(reference[0]);
  if (sign == std::string_view::npos) return std::nullopt;
  const double value = *degrees + FindNumber(exif, key, 1).value_or(0) / 60 +
                       FindNumber(exif, key, 2).value_or(0) / 3600;
  return Angle::Degrees(sign == 0 ? value : -value);
}

std::optional<GeoPoint> FindPlace(const Exiv2::ExifData& exif) {
  const auto latitude =
      FindAngle(exif, "Exif.GPSInfo.GPSLatitude", "Exif.GPSInfo.GPSLatitudeRef", "NS");
  const auto longitude =
      FindAngle(exif, "Exif.GPSInfo.GPSLongitude", "Exif.GPSInfo.GPSLongitudeRef", "EW");
  if (!latitude || !longitude) return std::nullopt;
  // A receiver without a fix says so, or writes zeros.
  if (FindText(exif, "Exif.GPSInfo.GPSStatus") == "V") return std::nullopt;
  if (latitude->radians() == 0 && longitude->radians() == 0) return std::nullopt;
  double height_m = FindNumber(exif, "Exif.GPSInfo.GPSAltitude").value_or(0);
  const auto below = FindNumber(exif, "Exif.GPSInfo.GPSAltitudeRef").value_or(0);
  if (below == 1 || below == 3) height_m = -height_m;
  const GeoPoint place{*latitude, *longitude, height_m};
  if (!place.Validate() || std::abs(height_m) > 9000) return std::nullopt;
  return place;
}

std::optional<double> FindSigma(const Exiv2::ExifData& exif) {
  auto sigma_m = FindPositive(exif, "Exif.GPSInfo.GPSHPositioningError");
  if (!sigma_m) sigma_m = FindPositive(exif, "Exif.GPSInfo.GPSDOP");
  return sigma_m && *sigma_m < 1e4 ? sigma_m : std::nullopt;
}

PhotoExif Interpret(const Exiv2::ExifData& exif) {
  PhotoExif photo;
  photo.make = FindText(exif, "Exif.Image.Make");
  photo.model = FindText(exif, "Exif.Image.Model");
  photo.lens = {FindPositive(exif, "Exif.Photo.FocalLength"),
                FindPositive(exif, "Exif.Photo.FocalLengthIn35mmFilm"), FindSensorWidthMm(exif)};
  photo.time = FindCaptureTime(exif);
  if (!photo.time) photo.time = FindGpsTime(exif);
  photo.place = FindPlace(exif);
  photo.sigma_m = FindSigma(exif);
  return photo;
}

}  // namespace

Result<PhotoExif> ReadPhotoExif(std::span<const std::uint8_t> bytes) {
  try {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);  // what it would print, we return
    const auto image = Exiv2::ImageFactory::open(bytes.data(), static_cast<long>(bytes.size()));
    image->readMetadata();
    if (image->exifData().empty()) return Error{ErrorCode::kNotFound, "has no EXIF"};
    return Interpret(image->exifData());
  } catch (const std::exception& failure) {
    return MakeError(ErrorCode::kCorrupt, "has unreadable EXIF ({})", failure.what());
  }
}

}  // namespace waymark::mapping::internal
