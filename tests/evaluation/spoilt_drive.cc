// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/spoilt_drive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "tests/evaluation/data.h"

namespace waymark::evaluation {
namespace {

namespace fs = std::filesystem;

enum class Fault { kNone, kGlare, kHang, kWrongOrder };

/// What happens at each moment of the drive.
std::vector<Fault> PlanFaults(std::size_t moments, const SpoilPlan& plan, std::mt19937_64& random) {
  std::vector<Fault> faults(moments, Fault::kNone);
  const auto length = std::max<std::size_t>(
      2, static_cast<std::size_t>(std::lround(plan.stretch * static_cast<double>(moments))));
  const auto stretches = static_cast<std::size_t>(
      std::lround(plan.share * static_cast<double>(moments) / static_cast<double>(length)));
  std::vector<std::size_t> slots(moments / length);
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = i;
  std::shuffle(slots.begin(), slots.end(), random);
  for (std::size_t i = 0; i < std::min(stretches, slots.size()); ++i) {
    const auto begin = faults.begin() + static_cast<std::ptrdiff_t>(slots[i] * length);
    std::fill_n(begin, length, static_cast<Fault>(1 + i % 3));
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
  explicit Reel(std::vector<const mapping::ImageRecord*> records) : records_(std::move(records)) {}

  /// Returns how many pictures are not what they say.
  Result<std::size_t> Store(const mapping::Experience& drive, const fs::path& to,
                            const std::map<SensorTime, Fault>& faults) const {
    std::size_t spoilt = 0;
    for (std::size_t i = 0; i < records_.size(); ++i) {
      const Fault fault = faults.at(records_[i]->time);
      const fs::path path = to / "sensors/records_data" / records_[i]->name;
      WAYMARK_TRY(CreateFolders(path.parent_path()));
      spoilt += fault != Fault::kNone;
      if (fault == Fault::kGlare) {
        WAYMARK_TRY(StoreGlare(drive.ImagePath(*records_[i]), path));
      } else {
        WAYMARK_TRY(LinkFile(drive.ImagePath(*records_[Shown(i, faults)]), path));
      }
    }
    return spoilt;
  }

 private:
  /// The picture that is stored in place of this one.
  std::size_t Shown(std::size_t at, const std::map<SensorTime, Fault>& faults) const {
    const Fault fault = faults.at(records_[at]->time);
    if (fault == Fault::kNone) return at;
    std::size_t first = at, last = at;
    while (first > 0 && faults.at(records_[first - 1]->time) == fault) --first;
    while (last + 1 < records_.size() && faults.at(records_[last + 1]->time) == fault) ++last;
    return fault == Fault::kHang ? first : first + last - at;
  }

  std::vector<const mapping::ImageRecord*> records_;
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
    faults.emplace(image.time, Fault::kNone);
    reels[image.camera].push_back(&image);
  }
  std::mt19937_64 random(plan.seed);
  const std::vector<Fault> planned = PlanFaults(faults.size(), plan, random);
  auto next = planned.begin();
  for (auto& [time, fault] : faults) fault = *next++;
  SpoiltDrive spoilt{.images = drive.images.size()};
  for (const auto& [camera, records] : reels) {
    WAYMARK_TRY_ASSIGN(const std::size_t count, Reel(records).Store(drive, to, faults));
    spoilt.spoilt += count;
  }
  return spoilt;
}

}  // namespace waymark::evaluation
