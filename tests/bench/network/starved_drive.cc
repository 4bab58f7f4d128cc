// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/network/starved_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <thread>

#include "session/wire/frames.h"
#include "tests/support/processor_time.h"

namespace waymark::bench {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using session::DeviceSession;

constexpr auto kPace = 200ms;  // between keyframes, 2 m apart: a fast cyclist

/// What is left of a picture; the same for the same seed.
std::vector<std::uint8_t> Shown(const mapping::GrayImage& image, const Trial& trial,
                                unsigned seed) {
  std::vector<std::uint8_t> pixels = image.pixels;
  const int width = image.width_px;
  const int strip = static_cast<int>(trial.strip * width);
  std::mt19937 random(seed);
  const int begin = static_cast<int>(random() % static_cast<unsigned>(width - strip + 1));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int u = static_cast<int>(i) % width;
    if (u < begin || u >= begin + strip) pixels[i] = 128;
  }
  if (trial.is_mirrored) {
    for (auto row = pixels.begin(); row != pixels.end(); row += width) {
      std::reverse(row, row + width);
    }
  }
  return pixels;
}

}  // namespace

Result<std::unique_ptr<StarvedDrive>> StarvedDrive::Open(const std::filesystem::path& drive,
                                                         const std::filesystem::path& scratch,
                                                         int dds_domain) {
  auto place = std::make_unique<StarvedDrive>();
  WAYMARK_TRY_ASSIGN(const DriveMap built, BuildDriveMap(drive, scratch));
  WAYMARK_TRY_ASSIGN(const auto map, mapping::MapDirectory::Open(built.map));
  WAYMARK_TRY_ASSIGN(const auto release, map.LoadCurrentRelease());
  WAYMARK_TRY_ASSIGN(const auto localiser, localiser::Localiser::Create(map, release, {}));
  WAYMARK_TRY(place->LoadSteps(built.asked, *localiser));
  const auto store = scratch / "anchors.db";
  WAYMARK_TRY_ASSIGN(auto anchors, content::OpenStore(store.string()));
  const auto localise = MakeLocaliseFunction(localiser, map.description(),
                                             std::make_shared<session::UnfoundImages>());
  WAYMARK_TRY_ASSIGN(
      place->server_,
      session::Server::Start(
          {.dds_domain = dds_domain},
          {.map = map.description(),
           .served = {release,
                      [raw = place.get(), localise](const session::LocaliseQuery& query) {
                        return raw->Answer(query, localise);
                      }},
           .store = std::move(anchors)}));
  WAYMARK_TRY_ASSIGN(place->gateway_, session::Gateway::Start({.dds = {.domain = dds_domain}}));
  return place;
}

Result<void> StarvedDrive::Try(const Trial& trial, Tally& tally) {
  std::unique_ptr<DeviceSession> phone;
  int keyframes = 0;
  for (std::size_t i = 0; i + 1 < 2 * steps_.size(); ++i) {
    const std::size_t at = i < steps_.size() ? i : 2 * steps_.size() - 2 - i;
    if (phone == nullptr) {
      WAYMARK_TRY_ASSIGN(phone, Join(trial));
      ++tally.phones;
      keyframes = 0;
    }
    const auto begin = Clock::now();
    const Asked asked = Ask(*phone, trial, at, static_cast<unsigned>(i));
    Count(asked, ++keyframes, tally);
    if (asked.answer.pose) phone.reset();
    std::this_thread::sleep_until(begin + kPace);
  }
  return {};
}

Result<void> StarvedDrive::LoadSteps(const std::filesystem::path& folder,
                                     const localiser::Localiser& localiser) {
  WAYMARK_TRY_ASSIGN(auto pictures, LoadPictures(folder, 1));
  for (Picture& picture : pictures) {
    const auto whole =
        localiser.Localise({picture.image, picture.camera, std::nullopt, std::nullopt});
    if (whole.pose) steps_.push_back({std::move(picture), whole.pose->map_from_camera});
  }
  return {};
}

Result<localiser::Localisation> StarvedDrive::Answer(const session::LocaliseQuery& query,
                                                     const session::LocaliseFunction& localise) {
  const double begin_s = support::ThreadTimeS();
  auto answer = localise(query);
  if (!answer) return answer;
  const std::lock_guard lock(mutex_);
  asked_.processor_ms = 1e3 * (support::ThreadTimeS() - begin_s);
  asked_.answer = *answer;
  session::LocaliseQuery bare = query;
  bare.vo_from_camera.reset();
  bare.earlier.clear();
  const auto bytes = [](const session::LocaliseQuery& any) {
    return static_cast<double>(session::wire::EncodeFrame(session::wire::Upward(any)).size());
  };
  asked_.bytes = bytes(query);
  asked_.extra_bytes = asked_.bytes - bytes(bare);
  return answer;
}

Result<std::unique_ptr<DeviceSession>> StarvedDrive::Join(const Trial& trial) const {
  session::DeviceOptions options{.server = fmt::format("ws://127.0.0.1:{}", gateway_->port()),
                                 .room = RoomId("road"),
                                 .keyframe_interval = 0s,
                                 .keyframe_sizes = session::KeyframeSizes::kAsTaken,
                                 .request_timeout = 60s};
  options.burst_images = trial.burst_images;
  if (trial.features > 0) {
    options.keyframe_content = session::KeyframeContent::kFeatures;
    options.max_sent_features = trial.features;
  }
  return DeviceSession::Join(options);
}

StarvedDrive::Asked StarvedDrive::Ask(DeviceSession& phone, const Trial& trial, std::size_t at,
                                      unsigned seed) {
  const Step& step = steps_[at];
  const DeviceTime now(
      std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()));
  const Transform<Vo, Device> vo_from_device(
      turn * step.map_from_camera.rotation(),
      trial.odometry_scale * (turn * step.map_from_camera.translation()));
  phone.PushOdometry(vo_from_device, now);
  const auto count = [&] {
    const auto statistics = phone.Statistics();
    return statistics.fixes + statistics.refusals + statistics.timeouts;
  };
  const int answers = count();
  (void)phone.PushFrame({.width_px = step.picture.image.width_px,
                         .height_px = step.picture.image.height_px,
                         .pixels = Shown(step.picture.image, trial, seed),
                         .camera = step.picture.camera,
                         .device_from_camera = {},
                         .vo_from_device = vo_from_device,
                         .time = now,
                         .gnss = step.picture.gnss});
  while (count() == answers) std::this_thread::sleep_for(1ms);
  const std::lock_guard lock(mutex_);
  asked_.truth = step.map_from_camera;
  return asked_;
}

void StarvedDrive::Count(const Asked& asked, int keyframes, Tally& tally) {
  ++tally.keyframes;
  tally.bytes += asked.bytes;
  tally.extra_bytes += asked.extra_bytes;
  const bool is_together = asked.answer.reason.find("images together") != std::string::npos ||
                           (asked.answer.pose && asked.answer.pose->images > 1);
  (is_together ? tally.together_ms : tally.alone_ms).push_back(asked.processor_ms);
  tally.most = std::max(tally.most, keyframes);
  if (!asked.answer.pose) return;
  ++tally.found;
  tally.together += is_together;
  const Rigid3& pose = asked.answer.pose->map_from_camera.rigid();
  const double error_m = (pose.translation() - asked.truth.translation()).norm();
  tally.errors_m.push_back(error_m);
  const bool is_false =
      error_m > 1 || AngleBetween(pose.rotation(), asked.truth.rotation()) > Angle::Degrees(5);
  if (is_false) fmt::print(stderr, "off by {:.2f} m: {}\n", error_m, asked.answer.reason);
  tally.false_poses += is_false;
}

}  // namespace waymark::bench
