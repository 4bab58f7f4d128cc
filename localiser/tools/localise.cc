// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "localiser/internal/batch.h"
#include "localiser/internal/burst/query.h"
#include "localiser/tools/localise_options.h"
#include "mapping/base/file.h"
#include "mapping/base/log.h"

namespace waymark::localiser {
namespace {

void ReportRefusals(std::span<const internal::LocalisedImage> images) {
  for (const auto& [name, answer] : images) {
    if (!answer.pose) LogInfo("{}: {}", name, answer.reason);
  }
}

// An answer that cannot be stored should be known before the work.
Result<void> CheckOutFolder(const std::filesystem::path& out) {
  std::error_code ignored;
  const auto folder = out.has_parent_path() ? out.parent_path() : ".";
  if (std::filesystem::is_directory(folder, ignored)) return {};
  return MakeError(ErrorCode::kNotFound, "--out {}: expected a folder {}, found none", out.string(),
                   folder.string());
}

Result<std::shared_ptr<const Localiser>> Open(const mapping::MapDirectory& map,
                                              const LocaliseArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  const LocaliserOptions options{
      .search = arguments.search,
      .memory_budget_bytes = static_cast<std::size_t>(1e6 * arguments.memory_mb)};
  WAYMARK_TRY_ASSIGN(auto localiser, Localiser::Create(map, release, options));
  LogInfo("{}: epoch {}, {} submaps", arguments.map, release.epoch, release.submaps.size());
  return localiser;
}

Result<void> LocaliseBurst(const LocaliseArguments& arguments, const mapping::MapDirectory& map,
                           const std::optional<CameraModel>& camera) {
  const auto& up = arguments.odometry_up;
  WAYMARK_TRY_ASSIGN(const BurstRequest burst,
                     internal::LoadBurst({.images = arguments.queries,
                                          .odometry = arguments.odometry,
                                          .camera = camera,
                                          .up_in_odometry = {up[0], up[1], up[2]}}));
  WAYMARK_TRY_ASSIGN(const auto localiser, Open(map, arguments));
  const internal::LocalisedImage last{arguments.queries.back(), localiser->Localise(burst)};
  WAYMARK_TRY(StoreFileAtomically(arguments.out, internal::EncodePoseTable({&last, 1})));
  fmt::print("{}\n{}: {}\n", internal::Summarise({&last, 1}), last.name, last.answer.reason);
  return {};
}

Result<void> LocaliseEach(const LocaliseArguments& arguments, const mapping::MapDirectory& map,
                          const std::optional<CameraModel>& camera) {
  if (arguments.queries.size() > 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "expected one QUERY, found {}: several images are a burst, with --odometry",
                     arguments.queries.size());
  }
  WAYMARK_TRY_ASSIGN(auto images, internal::FindQueryImages(arguments.queries.front(), camera));
  if (!arguments.list.empty()) {
    WAYMARK_TRY_ASSIGN(images, internal::SelectListed(images, arguments.list));
  }
  WAYMARK_TRY_ASSIGN(const auto localiser, Open(map, arguments));
  internal::BatchOptions options;
  options.parallelism.threads = arguments.threads;
  if (!arguments.no_prior && map.description().is_geo_aligned) {
    options.map_plane = TangentPlane(map.description().origin);
  }
  const std::size_t step = std::max<std::size_t>(1, images.size() / 10);
  const auto progress = [&](std::size_t done) {
    if (done % step == 0) LogInfo("{} of {} images", done, images.size());
  };
  const auto answers = internal::LocaliseBatch(*localiser, images, options, progress);
  if (arguments.verbose) ReportRefusals(answers);
  WAYMARK_TRY(StoreFileAtomically(arguments.out, internal::EncodePoseTable(answers)));
  fmt::print("{}\n{}\n", internal::Summarise(answers), internal::Describe(localiser->memory()));
  return {};
}

Result<void> Localise(const LocaliseArguments& arguments) {
  WAYMARK_TRY(CheckOutFolder(arguments.out));
  std::optional<CameraModel> camera;
  if (!arguments.camera.empty()) {
    WAYMARK_TRY_ASSIGN(camera, internal::ParseCamera(arguments.camera));
  }
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(arguments.map));
  return arguments.odometry.empty() ? LocaliseEach(arguments, map, camera)
                                    : LocaliseBurst(arguments, map, camera);
}

int Run(int argc, char** argv) {
  CLI::App app("Finds where images were taken in the live release of a map.");
  LocaliseArguments arguments;
  AddLocaliseOptions(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const Result<void> done = Localise(arguments);
  if (done) return 0;
  fmt::print(stderr, "waymark-localise: {}\n", ToString(done.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::localiser

int main(int argc, char** argv) { return waymark::localiser::Run(argc, argv); }
