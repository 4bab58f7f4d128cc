// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/network/drive_map.h"

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "tests/evaluation/data.h"
#include "tests/evaluation/running.h"

namespace waymark::bench {

Result<DriveMap> BuildDriveMap(const std::filesystem::path& drive,
                               const std::filesystem::path& scratch) {
  const std::filesystem::path base = scratch / drive.filename();
  DriveMap built{base / "map", base / "asked"};
  if (std::filesystem::exists(built.map / "current")) return built;
  const auto even = [](std::size_t i, const std::string&) { return i % 2 == 0; };
  const auto odd = [](std::size_t i, const std::string&) { return i % 2 == 1; };
  WAYMARK_TRY(evaluation::StoreKaptureSubset(drive, base / "mapped", even));
  WAYMARK_TRY(evaluation::StoreKaptureSubset(drive, built.asked, odd));
  WAYMARK_TRY(evaluation::RunProgram(evaluation::ExecutableFolder() / "waymark-map",
                                     {"add", built.map.string(), (base / "mapped").string()},
                                     base / "log"));
  return built;
}

Result<std::vector<Picture>> LoadPictures(const std::filesystem::path& folder, std::size_t every) {
  WAYMARK_TRY_ASSIGN(const auto experience, mapping::LoadKapture(folder));
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < experience.images.size(); i += every) {
    const mapping::ImageRecord& record = experience.images[i];
    WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(experience.ImagePath(record)));
    WAYMARK_TRY_ASSIGN(auto image, mapping::DecodeGrayImage(bytes));
    std::optional<GeoPoint> place;
    for (const mapping::GnssRecord& gnss : experience.gnss) {
      if (gnss.time <= record.time) place = gnss.place;
    }
    pictures.push_back(
        {record.name, std::move(image), experience.cameras.at(record.camera).model, place});
  }
  return pictures;
}

}  // namespace waymark::bench
