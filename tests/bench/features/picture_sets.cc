// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/features/picture_sets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <opencv2/calib3d.hpp>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "mapping/matching/descriptor_matching.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;

constexpr double kCorrect_px = 2;

Result<GrayImage> LoadImage(const fs::path& path) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(path));
  return DecodeGrayImage(bytes);
}

void AddPairs(PictureSet& set, std::initializer_list<std::size_t> distances, std::size_t stride) {
  for (const std::size_t distance : distances) {
    for (std::size_t i = 0; i + distance < set.images.size(); i += stride) {
      set.pairs.emplace_back(i, i + distance);
    }
  }
}

Result<PictureSet> LoadWithTruth(const fs::path& folder) {
  WAYMARK_TRY_ASSIGN(const Experience experience, LoadKapture(folder));
  WAYMARK_TRY_ASSIGN(const auto truth, evaluation::LoadTumTrajectory(folder / "truth.tum"));
  PictureSet set{.name = folder.filename(), .images = {}};
  set.camera = experience.cameras.begin()->second.model;
  for (const ImageRecord& record : experience.images) {
    const auto pose = truth.find(record.name);
    if (pose == truth.end()) continue;
    WAYMARK_TRY_ASSIGN(GrayImage image, LoadImage(experience.ImagePath(record)));
    set.images.push_back(std::move(image));
    set.world_from_camera.push_back(pose->second);
  }
  return set;
}

Eigen::Matrix3d Calibration(const CameraModel& camera) {
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = camera.FocalX();
  k(1, 1) = camera.FocalY();
  k.topRightCorner<2, 1>() = camera.PrincipalPoint();
  return k;
}

/// x2^T F x1 = 0.
Eigen::Matrix3d TrueFundamental(const PictureSet& set, std::size_t first, std::size_t second) {
  const Rigid3 second_from_first =
      set.world_from_camera[second].Inverse() * set.world_from_camera[first];
  const Eigen::Vector3d t = second_from_first.translation();
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d inverse = Calibration(*set.camera).inverse();
  return inverse.transpose() * cross * second_from_first.rotation().toRotationMatrix() * inverse;
}

Eigen::Matrix3d RobustFundamental(const std::vector<cv::Point2f>& first,
                                  const std::vector<cv::Point2f>& second) {
  Eigen::Matrix3d fundamental = Eigen::Matrix3d::Zero();
  if (first.size() < 8) return fundamental;
  const cv::Mat found =
      cv::findFundamentalMat(first, second, cv::USAC_ACCURATE, kCorrect_px, 0.9999, 5000);
  if (found.rows != 3) return fundamental;
  for (int i = 0; i < 9; ++i) fundamental(i / 3, i % 3) = found.at<double>(i / 3, i % 3);
  return fundamental;
}

double DistanceToLine(const Eigen::Vector3d& line, const Eigen::Vector3d& point) {
  return std::abs(line.dot(point)) / line.head<2>().norm();
}

}  // namespace

Result<PictureSet> LoadPictureSet(const fs::path& data, const std::string& name,
                                  std::size_t stride) {
  if (name == "lund") {
    WAYMARK_TRY_ASSIGN(PictureSet set, LoadFolder(data / name, 1000));
    AddPairs(set, {1, 3}, 1);
    return set;
  }
  WAYMARK_TRY_ASSIGN(PictureSet set, LoadWithTruth(data / name));
  if (name.starts_with("kitti")) AddPairs(set, {5, 10}, stride);
  if (name.starts_with("pavilion")) AddPairs(set, {1}, stride);
  if (name == "fountain") AddPairs(set, {2, 4}, 1);
  return set;
}

Result<PictureSet> LoadFolder(const fs::path& folder, std::size_t limit) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".jpg" || extension == ".png") paths.push_back(entry.path());
  }
  if (error) {
    return MakeError(ErrorCode::kNotFound, "{}: {}", folder.string(), error.message());
  }
  std::sort(paths.begin(), paths.end());
  if (paths.size() > limit) paths.resize(limit);
  PictureSet set{.name = folder.filename(), .images = {}};
  for (const fs::path& path : paths) {
    WAYMARK_TRY_ASSIGN(GrayImage image, LoadImage(path));
    set.images.push_back(std::move(image));
  }
  return set;
}

PairQuality JudgePair(const PictureSet& set, std::pair<std::size_t, std::size_t> pair,
                      const ImageFeatures& first, const ImageFeatures& second) {
  const auto matches = MatchDescriptors(first.descriptors, second.descriptors, {});
  std::vector<cv::Point2f> a, b;
  for (const FeatureMatch& match : matches) {
    a.emplace_back(first.keypoints[match.first].x_px, first.keypoints[match.first].y_px);
    b.emplace_back(second.keypoints[match.second].x_px, second.keypoints[match.second].y_px);
  }
  const Eigen::Matrix3d fundamental =
      set.camera ? TrueFundamental(set, pair.first, pair.second) : RobustFundamental(a, b);
  PairQuality quality;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector3d x(a[i].x, a[i].y, 1), y(b[i].x, b[i].y, 1);
    const double there_px = DistanceToLine(fundamental * x, y);
    const double back_px = DistanceToLine(fundamental.transpose() * y, x);
    if (!(there_px < kCorrect_px && back_px < kCorrect_px)) continue;
    ++quality.correct;
    quality.errors_px.push_back((there_px + back_px) / 2);
  }
  return quality;
}

}  // namespace waymark::mapping
