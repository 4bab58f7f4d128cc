// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>
#include <utility>

#include "mapping/base/file.h"
#include "mapping/base/median.h"

namespace waymark::localiser::internal {
namespace {

Result<LocalisationRequest> MakeRequest(const QueryImage& image, const BatchOptions& options) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(image.path));
  WAYMARK_TRY_ASSIGN(mapping::GrayImage pixels, mapping::DecodeGrayImage(bytes));
  auto camera = image.camera ? Result<CameraModel>(*image.camera) : GuessCamera(pixels);
  if (!camera) return camera.error();
  std::optional<PositionPrior> prior;
  if (image.gnss && options.map_plane) {
    prior = PositionPrior{options.map_plane->ToMap(image.gnss->place),
                          std::max(options.min_prior_radius_m, 5 * image.gnss->sigma_m)};
  }
  return LocalisationRequest{std::move(pixels), *camera, prior, std::nullopt};
}

Localisation Ask(const Localiser& localiser, const QueryImage& image, const BatchOptions& options) {
  const auto request = MakeRequest(image, options);
  if (request) return localiser.Localise(*request);
  Localisation answer;
  answer.status = LocalisationStatus::kInvalidRequest;
  answer.reason = ToString(request.error());
  answer.epoch = localiser.epoch();
  return answer;
}

// RFC 4180: quoted where needed, quotes doubled.
std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

double MedianOrZero(std::vector<double> values) {
  return values.empty() ? 0 : Median(std::move(values));
}

}  // namespace

std::vector<LocalisedImage> LocaliseBatch(const Localiser& localiser,
                                          std::span<const QueryImage> images,
                                          const BatchOptions& options,
                                          const std::function<void(std::size_t)>& progress) {
  std::vector<LocalisedImage> answers(images.size());
  std::atomic<std::size_t> done{0};
  ParallelFor(images.size(), options.parallelism, [&](std::size_t i) {
    answers[i] = {images[i].name, Ask(localiser, images[i], options)};
    if (progress) progress(++done);
  });
  return answers;
}

std::string EncodePoseTable(std::span<const LocalisedImage> images) {
  std::string table = "image,status,tx,ty,tz,qx,qy,qz,qw,inliers,submap,epoch,ms,experience\n";
  const auto out = std::back_inserter(table);
  for (const LocalisedImage& image : images) {
    const Localisation& answer = image.answer;
    fmt::format_to(out, "{},{},", CsvField(image.name), LocalisationStatusName(answer.status));
    if (answer.pose) {
      const Eigen::Vector3d& t = answer.pose->map_from_camera.translation();
      const Eigen::Quaterniond& q = answer.pose->map_from_camera.rotation();
      fmt::format_to(out, "{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{},{}", t.x(), t.y(),
                     t.z(), q.x(), q.y(), q.z(), q.w(), answer.pose->inliers,
                     answer.pose->submap.text());
    } else {
      table += ",,,,,,,0,";
    }
    const bool is_attributed = answer.pose && answer.pose->experience;
    fmt::format_to(out, ",{},{:.1f},{}\n", answer.epoch, answer.times.total_ms,
                   is_attributed ? CsvField(answer.pose->experience->text()) : "");
  }
  return table;
}

std::string Summarise(std::span<const LocalisedImage> images) {
  std::vector<double> inliers, features_ms, search_ms, pose_ms, total_ms;
  std::map<std::string_view, int> refusals;
  for (const auto& [name, answer] : images) {
    features_ms.push_back(answer.times.features_ms);
    search_ms.push_back(answer.times.search_ms);
    pose_ms.push_back(answer.times.pose_ms);
    total_ms.push_back(answer.times.total_ms);
    if (answer.pose) {
      inliers.push_back(answer.pose->inliers);
    } else {
      ++refusals[LocalisationStatusName(answer.status)];
    }
  }
  const double share = images.empty() ? 0
                                      : 100.0 * static_cast<double>(inliers.size()) /
                                            static_cast<double>(images.size());
  std::string summary = fmt::format(
      "localised {} of {} images ({:.0f} %); median {:.0f} inliers, {:.0f} ms "
      "(features {:.0f}, search {:.0f}, pose {:.0f})",
      inliers.size(), images.size(), share, MedianOrZero(inliers), MedianOrZero(total_ms),
      MedianOrZero(features_ms), MedianOrZero(search_ms), MedianOrZero(pose_ms));
  for (const auto& [status, count] : refusals) summary += fmt::format("; {}: {}", status, count);
  return summary;
}

std::string Describe(const LocaliserMemory& memory) {
  const auto megabytes = [](std::size_t bytes) { return 1e-6 * static_cast<double>(bytes); };
  std::string text = fmt::format("{} submaps in memory, {:.1f} MB", memory.resident_submaps,
                                 megabytes(memory.resident_bytes));
  if (memory.budget_bytes == 0) return text;
  const double each_ms =
      memory.opening_ms / static_cast<double>(std::max<std::uint64_t>(1, memory.openings));
  return text + fmt::format(" (most {:.1f} of {:.1f}); {} opened in {:.0f} ms each, {} dropped",
                            megabytes(memory.peak_bytes), megabytes(memory.budget_bytes),
                            memory.openings, each_ms, memory.evictions);
}

}  // namespace waymark::localiser::internal
