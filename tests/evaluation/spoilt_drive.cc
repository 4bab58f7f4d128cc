// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/spoilt_drive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "tests/evaluation/data.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

using Fault = std::optional<PictureFault>;

/// What happens at each moment of the drive.
std::vector<Fault> PlanFaults(std::size_t moments, const SpoilPlan& plan, std::mt19937_64& random) {
  std::vector<Fault> faults(moments);
  const auto length = std::max<std::size_t>(
      2, static_cast<std::size_t>(std::lround(plan.stretch * static_cast<double>(moments))));
  const auto stretches = static_cast<std::size_t>(
      std::lround(plan.share * static_cast<double>(moments) / static_cast<double>(length)));
  std::vector<std::size_t> slots(moments / length);
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = i;
  std::shuffle(slots.begin(), slots.end(), random);
  for (std::size_t i = 0; i < std::min(stretches, slots.size()); ++i) {
    const auto begin = faults.begin() + static_cast<std::ptrdiff_t>(slots[i] * length);
    std::fill_n(begin, length, Fault(plan.faults[i % plan.faults.size()]));
  }
  return faults;
}

Result<void> StoreGlare(const fs::path& from, const fs::path& to) {
  const cv::Mat picture = cv::imread(from.string());
  if (picture.empty()) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected a picture", from.string());
  }
  cv::Mat washed;
  cv::GaussianBlur(picture, washed, {}, picture.cols / 20.0);
  washed.convertTo(washed, -1, 0.15, 215);
  if (cv::imwrite(to.string(), washed)) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: cannot be written", to.string());
}

/// The pictures of one camera.
class Reel {
 public:
  Reel(std::vector<const mapping::ImageRecord*> records, const std::map<SensorTime, Fault>& faults,
       std::mt19937_64 random)
      : records_(std::move(records)), shown_(records_.size()) {
    for (const mapping::ImageRecord* record : records_) faults_.push_back(faults.at(record->time));
    std::iota(shown_.begin(), shown_.end(), std::size_t{0});
    for (std::size_t begin = 0, end = 0; begin < records_.size(); begin = end) {
      while (end < records_.size() && faults_[end] == faults_[begin]) ++end;
      if (faults_[begin]) Rearrange(*faults_[begin], begin, end, random);
    }
  }

  /// Returns how many pictures are not what they say.
  Result<std::size_t> Store(const mapping::Experience& drive, const fs::path& to) const {
    std::size_t spoilt = 0;
    for (std::size_t i = 0; i < records_.size(); ++i) {
      const fs::path path = to / "sensors/records_data" / records_[i]->name;
      WAYMARK_TRY(CreateFolders(path.parent_path()));
      spoilt += faults_[i].has_value();
      if (faults_[i] == PictureFault::kGlare) {
        WAYMARK_TRY(StoreGlare(drive.ImagePath(*records_[i]), path));
      } else {
        WAYMARK_TRY(LinkFile(drive.ImagePath(*records_[shown_[i]]), path));
      }
    }
    return spoilt;
  }

 private:
  void Rearrange(PictureFault fault, std::size_t begin, std::size_t end, std::mt19937_64& random) {
    const std::span<std::size_t> shown = std::span(shown_).subspan(begin, end - begin);
    switch (fault) {
      case PictureFault::kGlare:
        break;
      case PictureFault::kHang:
        std::ranges::fill(shown, begin);
        break;
      case PictureFault::kWrongOrder:
        std::ranges::reverse(shown);
        break;
      case PictureFault::kMixedUp:
        std::ranges::shuffle(shown, random);
        break;
      case PictureFault::kLate:
        for (std::size_t& index : shown) index -= std::min(index, shown.size() / 3);
        break;
    }
  }

  std::vector<const mapping::ImageRecord*> records_;
  std::vector<Fault> faults_;       // by record
  std::vector<std::size_t> shown_;  // by record: whose picture is stored
};

}  // namespace

Result<SpoiltDrive> StoreSpoiltDrive(const fs::path& from, const fs::path& to,
                                     const SpoilPlan& plan) {
  WAYMARK_TRY_ASSIGN(const mapping::Experience drive, mapping::LoadKapture(from));
  WAYMARK_TRY(CreateFolders(to / "sensors/records_data"));
  WAYMARK_TRY_ASSIGN(const std::vector<std::string> names, ListFolder(from / "sensors"));
  for (const std::string& name : names) {
    if (name != "records_data")
      WAYMARK_TRY(LinkFile(from / "sensors" / name, to / "sensors" / name));
  }
  std::map<SensorTime, Fault> faults;
  std::map<std::string, std::vector<const mapping::ImageRecord*>> reels;
  for (const mapping::ImageRecord& image : drive.images) {
    faults.emplace(image.time, std::nullopt);
    reels[image.camera].push_back(&image);
  }
  std::mt19937_64 random(plan.seed);
  const std::vector<Fault> planned = PlanFaults(faults.size(), plan, random);
  auto next = planned.begin();
  for (auto& [time, fault] : faults) fault = *next++;
  SpoiltDrive spoilt{.images = drive.images.size()};
  for (const auto& [camera, records] : reels) {
    WAYMARK_TRY_ASSIGN(const std::size_t count, Reel(records, faults, random).Store(drive, to));
    spoilt.spoilt += count;
  }
  return spoilt;
}

}  // namespace waymark::evaluation
