// SPDX-License-Identifier: Apache-2.0
// What is wrong with a kapture folder is named with its file and line, and never crashes the
// reader.
#include <gmock/gmock.h>

#include <random>

#include "mapping/experience/kapture.h"
#include "tests/mapping/experience/kapture_folder.h"

namespace waymark::mapping {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct BadTable {
  std::string name;
  std::string table;
  std::string text;
  ErrorCode code;
  std::string place;   ///< how the message names where
  std::string reason;  ///< a piece of what it says
};

void PrintTo(const BadTable& bad, std::ostream* out) { *out << bad.name; }

class BadKapture : public KaptureFolder, public testing::WithParamInterface<BadTable> {};

TEST_P(BadKapture, IsRefusedNamingFileAndLine) {
  const BadTable& bad = GetParam();
  Write(bad.table, bad.text);
  const auto result = LoadKapture(folder_);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, bad.code);
  EXPECT_THAT(result.error().message, HasSubstr(bad.table + bad.place));
  EXPECT_THAT(result.error().message, AllOf(HasSubstr(": expected "), HasSubstr(bad.reason)));
  EXPECT_LT(result.error().message.size(), 500u);
}

std::vector<BadTable> BadTables() {
  const std::string h = "# kapture format: 1.1\n";
  const auto corrupt = ErrorCode::kCorrupt;
  const auto unsupported = ErrorCode::kUnsupported;
  const std::string camera = "records_camera.txt", gnss = "records_gnss.txt";
  return {
      {"empty", camera, "", corrupt, ":1:", "found nothing"},
      {"garbage", camera, std::string("\x00\xff\x7f\x01PNG", 7), corrupt, ":1:", "\"?"},
      {"old_version", camera, "# kapture format: 1.0\n", unsupported, ":1:", "\"1.0\""},
      {"missing_field", camera, h + "1, cam0\n", corrupt, ":2:", "3 fields"},
      {"extra_field", camera, h + "1, cam0, front/1.jpg, x\n", corrupt, ":2:", "found 4"},
      {"overflowing_time", camera, h + "99999999999999999999, cam0, a\n", corrupt, ":2:", "whole"},
      {"negative_time", camera, h + "-1, cam0, front/1.jpg\n", corrupt, ":2:", "\"-1\""},
      {"word_as_time", camera, h + "\n#\nnow, cam0, a\n", corrupt, ":4:", "\"now\""},
      {"unknown_camera", camera, h + "1, cam7, front/1.jpg\n", corrupt, ":2:", "\"cam7\""},
      {"gnss_as_camera", camera, h + "1, gps0, front/1.jpg\n", corrupt, ":2:", "a camera"},
      {"parent_folder", camera, h + "1, cam0, ../sensors.txt\n", corrupt, ":2:", "inside"},
      {"absolute_path", camera, h + "1, cam0, /etc/passwd\n", corrupt, ":2:", "inside"},
      {"hidden_parent", camera, h + "1, cam0, front/../1.jpg\n", corrupt, ":2:", "inside"},
      {"empty_name", camera, h + "1, cam0,\n", corrupt, ":2:", "nothing"},
      {"bell_in_name", camera, h + "1, cam0, a\a.jpg\n", corrupt, ":2:", "a?.jpg"},
      {"bad_utf8", camera, h + "1, cam0, a\xc3.jpg\n", corrupt, ":2:", "a?.jpg"},
      {"same_image", camera, h + "1, cam0, front/1.jpg\n2, cam0, front/1.jpg\n", corrupt,
       ":3:", "again"},
      {"same_instant", camera, h + "1, cam0, front/1.jpg\n1, cam0, front/2.jpg\n", corrupt,
       ":3:", "one image per camera"},
      {"huge_line", camera, h + std::string(1 << 20, 'x'), corrupt, ":2:", "found 1"},
      {"many_fields", camera, h + std::string(1 << 20, ','), corrupt, ":2:", "found 1048577"},
      {"nan", gnss, h + "1, gps0, nan, 37, 0, 0, 1\n", corrupt, ":2:", "\"nan\""},
      {"infinite", gnss, h + "1, gps0, 1, inf, 0, 0, 1\n", corrupt, ":2:", "\"inf\""},
      {"overflow", gnss, h + "1, gps0, 1e999, 37, 0, 0, 1\n", corrupt, ":2:", "1e999"},
      {"swapped", gnss, h + "1, gps0, 37, -122, 0, 0, 1\n", corrupt, ":2:", "latitude"},
      {"negative_dop", gnss, h + "1, gps0, 1, 2, 0, 0, -1\n", corrupt, ":2:", "dop"},
      {"blank_height", gnss, h + "1, gps0, 1, 2, , 0, 1\n", corrupt, ":2:", "nothing"},
      {"trailing_text", gnss, h + "1, gps0, 1x, 2, 0, 0, 1\n", corrupt, ":2:", "1x"},
      {"fisheye", "sensors.txt", h + "cam0, , camera, FISHEYE, 1, 1, 1\n", unsupported,
       ":2:", "\"FISHEYE\""},
      {"odd_sensor", "sensors.txt", h + "cam0, , sonar\n", unsupported, ":2:", "\"sonar\""},
      {"short_camera", "sensors.txt", h + "cam0, , camera, PINHOLE, 1, 1, 1\n", corrupt,
       ":2:", "10 fields"},
      {"zero_width", "sensors.txt", h + "cam0, , camera, PINHOLE, 0, 1, 1, 1, 1, 1\n", corrupt,
       ":2:", "width"},
      {"zero_focal", "sensors.txt", h + "cam0, , camera, PINHOLE, 9, 9, 0, 1, 1, 1\n", corrupt,
       ":2:", "focal"},
      {"same_sensor", "sensors.txt", h + "a, , wifi\na, , wifi\n", corrupt, ":3:", "again"},
      {"other_datum", "sensors.txt", h + "g, , gnss, EPSG:2154\n", unsupported, ":2:", "4326"},
      {"unnormalised", "rigs.txt", h + "r, cam0, 2, 0, 0, 0, 0, 0, 0\n", corrupt, ":2:", "norm 2"},
      {"zero_rotation", "rigs.txt", h + "r, cam0, 0, 0, 0, 0, 0, 0, 0\n", corrupt, ":2:", "norm"},
      {"nested_rig", "rigs.txt", h + "r, rig1, 1, 0, 0, 0, 0, 0, 0\n", corrupt, ":2:", "rig1"},
      {"partial_pose", "trajectories.txt", h + "1, cam0, , , , , 1, 2, 3\n", unsupported,
       ":2:", "whole pose"},
      {"stranger", "trajectories.txt", h + "1, x, 1, 0, 0, 0, 1, 2, 3\n", corrupt, ":2:", "\"x\""},
      {"short_imu", "records_gyroscope.txt", h + "1, gyro0, 1, 2\n", corrupt, ":2:", "5 fields"},
  };
}

INSTANTIATE_TEST_SUITE_P(Tables, BadKapture, testing::ValuesIn(BadTables()),
                         [](const auto& test) { return test.param.name; });

using DamagedKapture = KaptureFolder;

TEST_F(DamagedKapture, NeverCrashTheReader) {
  std::mt19937 engine(7);
  for (const auto& [name, rows] : ValidTables()) {
    const std::string valid = kHeader + rows;
    for (std::size_t length = 0; length < valid.size(); ++length) {
      Write(name, valid.substr(0, length));
      (void)LoadKapture(folder_);
      std::string flipped = valid;
      flipped[length] = static_cast<char>(engine());
      Write(name, flipped);
      (void)LoadKapture(folder_);
    }
    Write(name, valid);
  }
  EXPECT_TRUE(LoadKapture(folder_));
}

}  // namespace
}  // namespace waymark::mapping
