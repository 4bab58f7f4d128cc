// SPDX-License-Identifier: Apache-2.0
// All tables of a recording at once, one after the other, separated by form feeds.
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "mapping/base/check.h"
#include "mapping/experience/kapture.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temporary_root.h"

namespace waymark::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr char kSeparator = '\f';
constexpr std::array kTables{"sensors.txt",
                             "rigs.txt",
                             "records_camera.txt",
                             "records_gnss.txt",
                             "records_accelerometer.txt",
                             "records_gyroscope.txt",
                             "trajectories.txt"};

/// Gone with the process.
class Folder {
 public:
  Folder() : path_(support::TemporaryRoot() / ("kapture_fuzz_" + std::to_string(getpid()))) {
    fs::create_directories(path_ / "sensors" / "records_data");
    std::ofstream(path_ / "sensors" / "records_data" / "a.jpg") << "pixels";
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

std::vector<Bytes> Seeds() {
  const std::string header = "# kapture format: 1.1\n";
  std::string recording = header + "cam, , camera, PINHOLE, 640, 480, 500, 500, 320, 240\n" +
                          "gps, , gnss, EPSG:4326\nacc, , accelerometer\ngyro, , gyroscope\n" +
                          kSeparator;
  recording += header + "car, cam, 1, 0, 0, 0, 0.1, 0.2, 0.3\n" + kSeparator;
  recording += header + "1000, cam, a.jpg\n" + kSeparator;
  recording += header + "1000, gps, 13.2, 55.7, 40, 0, 1.0\n" + kSeparator;
  recording += header + "1000, acc, 0.1, -9.8, 0.2\n" + kSeparator;
  recording += header + "1000, gyro, 0.01, 0.02, -0.03\n" + kSeparator;
  recording += header + "1000, cam, 1, 0, 0, 0, 1, 2, 3\n";
  return {ToBytes(recording)};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  static const Folder folder;
  std::string_view rest = ToText(bytes);
  for (const char* table : kTables) {
    const fs::path path = folder.path() / "sensors" / table;
    const std::size_t end = std::min(rest.find(kSeparator), rest.size());
    if (end == 0) {
      fs::remove(path);
    } else {
      std::ofstream(path, std::ios::binary) << rest.substr(0, end);
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  const auto experience = mapping::LoadKapture(folder.path());
  if (!experience) return;
  for (const mapping::ImageRecord& image : experience->images) {
    CHECK(experience->cameras.contains(image.camera), "image of unknown camera {}", image.camera);
  }
}

}  // namespace waymark::fuzz
