// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>

namespace waymark::mapping {

/// A small valid kapture folder whose tables a test replaces one at a time.
class KaptureFolder : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    root_ = std::filesystem::path(testing::TempDir()) /
            (std::string(test->test_suite_name()) + "." + test->name());
    std::filesystem::remove_all(root_);
    folder_ = root_ / "walk";
    std::filesystem::create_directories(folder_ / "sensors" / "records_data" / "front");
    for (const auto& [name, rows] : ValidTables()) Write(name, kHeader + rows);
    Write("records_data/front/1.jpg", "pixels");
    Write("records_data/front/2.jpg", "pixels");
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  void Write(const std::string& name, std::string_view text) const {
    std::ofstream(folder_ / "sensors" / name, std::ios::binary) << text;
  }

  static std::map<std::string, std::string> ValidTables() {
    return {{"sensors.txt",
             "# sensor_id, name, sensor_type, [sensor_params]+\n"
             "cam0, front, camera, OPENCV, 640, 480, 500, 510, 320, 240, -0.1, 0.02, 1e-3, -0.002\n"
             "cam1, , camera, UNKNOWN_CAMERA, 300, 400\n"
             "gps0, , gnss, EPSG:4326\n"
             "acc0, , accelerometer\n"
             "gyro0, , gyroscope\n"
             "wifi0, , wifi\n"},
            {"rigs.txt", "rig0, cam0, 0.5, -0.5, 0.5, -0.5, 0.1, 0.2, 1.5\n"},
            {"records_camera.txt", "200, cam1, front/2.jpg\n100, cam0, front/1.jpg\n"},
            {"records_gnss.txt",
             "100, gps0, -122.4194, 37.7749, 16.5, 0, 2.5\n90, gps0, 11.5, 48.25, 500, 0, 0\n"},
            {"records_accelerometer.txt", "100, acc0, 0.1, 9.8, -0.2\n"},
            {"records_gyroscope.txt", "100, gyro0, 0.01, 0.02, -0.03\n"},
            {"trajectories.txt", "100, rig0, 1, 0, 0, 0, 1, 2, 3\n"}};
  }

  static inline const std::string kHeader = "# kapture format: 1.1\n";
  std::filesystem::path root_;
  std::filesystem::path folder_;
};

}  // namespace waymark::mapping
