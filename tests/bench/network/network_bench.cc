// SPDX-License-Identifier: Apache-2.0
// Where the time of a localisation goes on a phone's network, how fresh its pose is for others
// meanwhile, and how well it knows the session's clock.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <thread>
#include <vector>

#include "mapping/base/quantile.h"
#include "session/device/device_session.h"
#include "tests/bench/network/drive_map.h"
#include "tests/evaluation/running.h"
#include "tests/evaluation/trajectory.h"
#include "tests/network/star.h"

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using network::Star;
using session::DeviceSession;
using session::KeyframeTiming;
using Clock = std::chrono::steady_clock;

struct Flags {
  std::string drive;
  std::string scratch = "/tmp/waymark_network_bench";
  std::vector<std::string> profiles{"4g", "3g"};
  double seconds = 40;
  double interval_s = 1;
  bool is_direct = false;
  bool is_as_taken = false;
};

/// A frame with the odometry that was true.
struct Step {
  Picture picture;
  Transform<Vo, Device> vo_from_device;
};

DeviceTime Now() {
  return DeviceTime(
      std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()));
}

Result<std::vector<Step>> LoadWalk(const fs::path& drive, const fs::path& asked) {
  WAYMARK_TRY_ASSIGN(const auto truth, evaluation::LoadTumTrajectory(drive / "truth.tum"));
  WAYMARK_TRY_ASSIGN(auto pictures, LoadPictures(asked, 1));
  std::vector<Step> walk;
  for (Picture& picture : pictures) {
    const auto pose = truth.find(picture.name);
    if (pose == truth.end()) continue;
    walk.push_back({std::move(picture), Transform<Vo, Device>(pose->second)});
  }
  return walk;
}

/// Goes there and back again, as a phone that knows its odometry and little else.
void Walk(DeviceSession& device, const std::vector<Step>& walk, const Flags& flags) {
  const Clock::time_point begin = Clock::now();
  const auto period = 33ms;
  const auto frames = static_cast<int>(flags.seconds / 0.033);
  const double frame_s = std::min(1.0, 0.5 * flags.interval_s);  // how long the phone looks at one
  for (int i = 0; i < frames; ++i) {
    std::this_thread::sleep_until(begin + i * period);
    const auto count = static_cast<int>(walk.size());
    const int at = static_cast<int>(0.033 * i / frame_s) % (2 * count - 2);
    const Step& step = walk[static_cast<std::size_t>(at < count ? at : 2 * count - 2 - at)];
    const DeviceTime now = Now();
    device.PushOdometry(step.vo_from_device, now);
    if (i % 3 != 0) continue;
    (void)device.PushFrame({.width_px = step.picture.image.width_px,
                            .height_px = step.picture.image.height_px,
                            .pixels = step.picture.image.pixels,
                            .camera = step.picture.camera,
                            .device_from_camera = {},
                            .vo_from_device = step.vo_from_device,
                            .time = now,
                            .gnss = step.picture.gnss});
  }
}

struct Series {
  std::vector<double> values;

  void Add(double value) { values.push_back(value); }
  double Quantile(double share) const { return waymark::Quantile<double>(values, share, NAN); }
};

struct Measured {
  session::DeviceStatistics statistics;
  Series pose_age_ms, clock_error_ms;
  double up_kB_per_s = 0, down_kB_per_s = 0;
};

session::DeviceOptions OptionsOf(Star& star, const Flags& flags, const std::string& name) {
  session::DeviceOptions options{
      .server = star.Url(),
      .authority_file = star.Authority(),
      .room = RoomId("road"),
      .name = name,
      .keyframe_interval = std::chrono::duration<double>(flags.interval_s),
      .request_timeout = 15s};
  if (flags.is_direct) options.server = Star::kAddress;
  if (flags.is_as_taken) options.keyframe_sizes = session::KeyframeSizes::kAsTaken;
  return options;
}

Result<std::unique_ptr<DeviceSession>> JoinAt(Star& star, int host,
                                              const session::DeviceOptions& options) {
  Result<std::unique_ptr<DeviceSession>> joined = Error{ErrorCode::kUnavailable, ""};
  star.emulator().Inside(host).Run([&] { joined = DeviceSession::Join(options); });
  return joined;
}

Result<Measured> MeasureOn(Star& star, const network::Profile& profile,
                           const std::vector<Step>& walk, const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const int phone_host, star.emulator().AddHost(profile));
  WAYMARK_TRY_ASSIGN(const int watcher_host,
                     star.emulator().AddHost(*network::FindProfile("none")));
  WAYMARK_TRY_ASSIGN(const auto phone, JoinAt(star, phone_host, OptionsOf(star, flags, "phone")));
  WAYMARK_TRY_ASSIGN(const auto watcher,
                     JoinAt(star, watcher_host, OptionsOf(star, flags, "watcher")));
  Measured measured;
  const auto up = star.emulator().CountersUp(phone_host);
  const auto down = star.emulator().CountersDown(phone_host);
  std::atomic<bool> has_ended = false;
  std::thread watching([&] {
    while (!has_ended) {
      std::this_thread::sleep_for(20ms);
      for (const auto& other : watcher->Others()) {
        if (other.map_from_device) measured.pose_age_ms.Add(1e3 * other.age.count());
      }
      const DeviceTime now = Now();  // this machine's clock is the server's too
      const auto session_time = phone->SessionTime(now);
      if (session_time) {
        measured.clock_error_ms.Add(
            1e3 * std::abs(Seconds(session_time->time_since_epoch() - now.time_since_epoch())));
      }
    }
  });
  Walk(*phone, walk, flags);
  has_ended = true;
  watching.join();
  measured.statistics = phone->Statistics();
  const auto rate = [&](const auto& before, const auto& after) {
    return static_cast<double>(after.bytes - before.bytes) / flags.seconds / 1e3;
  };
  measured.up_kB_per_s = rate(up, star.emulator().CountersUp(phone_host));
  measured.down_kB_per_s = rate(down, star.emulator().CountersDown(phone_host));
  return measured;
}

void Print(const std::string& name, Measured& measured) {
  constexpr std::array<std::pair<const char*, double KeyframeTiming::*>, 9> kStages{
      {{"encode", &KeyframeTiming::encode_ms},
       {"uplink", &KeyframeTiming::uplink_ms},
       {"queue", &KeyframeTiming::queue_ms},
       {"features", &KeyframeTiming::features_ms},
       {"search", &KeyframeTiming::search_ms},
       {"pose", &KeyframeTiming::pose_ms},
       {"server, all", &KeyframeTiming::server_ms},
       {"downlink", &KeyframeTiming::downlink_ms},
       {"total", &KeyframeTiming::total_ms}}};
  const auto& s = measured.statistics;
  fmt::print("{}: {} fixes of {} keyframes ({} not found, {} superseded, {} timeouts)\n", name,
             s.fixes, s.keyframes_sent, s.refusals, s.superseded, s.timeouts);
  for (const auto& [stage, member] : kStages) {
    Series series;
    for (const KeyframeTiming& timing : s.keyframe_timings) series.Add(timing.*member);
    fmt::print("  {:<12} {:>8.0f} {:>8.0f}\n", stage, series.Quantile(0.5), series.Quantile(0.95));
  }
  Series bytes, width;
  for (const KeyframeTiming& timing : s.keyframe_timings) {
    bytes.Add(1e-3 * static_cast<double>(timing.image_bytes));
    width.Add(timing.width_px);
  }
  fmt::print("  image {:.1f} kB, {:.0f} px wide; up {:.1f}, down {:.1f} kB/s\n",
             bytes.Quantile(0.5), width.Quantile(0.5), measured.up_kB_per_s,
             measured.down_kB_per_s);
  fmt::print("  age of its pose for others  p50 {:.0f}  p95 {:.0f}  p99 {:.0f} ms\n",
             measured.pose_age_ms.Quantile(0.5), measured.pose_age_ms.Quantile(0.95),
             measured.pose_age_ms.Quantile(0.99));
  fmt::print("  error of its session clock  p50 {:.2f}  p95 {:.2f}  max {:.2f} ms\n",
             measured.clock_error_ms.Quantile(0.5), measured.clock_error_ms.Quantile(0.95),
             measured.clock_error_ms.Quantile(1));
  std::fflush(stdout);
}

Result<void> Run(const Flags& flags) {
  WAYMARK_TRY_ASSIGN(const DriveMap place, BuildDriveMap(flags.drive, flags.scratch));
  WAYMARK_TRY_ASSIGN(const auto walk, LoadWalk(flags.drive, place.asked));
  const evaluation::ScratchFolder folder(false);
  const fs::path programs = evaluation::ExecutableFolder();
  WAYMARK_TRY_ASSIGN(const auto star, Star::Start(folder.path(),
                                                  {(programs / "waymark-serve").string(), "--map",
                                                   place.map.string(), "--store",
                                                   (folder.path() / "anchors.db").string(),
                                                   "--address", Star::kAddress, "--insecure"},
                                                  (programs / "waymark-gateway").string()));
  fmt::print("{}, {}; ms: median, 95th percentile. Published: 970 ms on 4G, 1,700 ms on 3G\n",
             flags.is_direct ? "over DDS" : "over WSS through the gateway",
             flags.is_as_taken ? "images as taken" : "images as the network allows");
  for (const std::string& name : flags.profiles) {
    const network::Profile* const profile = network::FindProfile(name);
    if (profile == nullptr) {
      return MakeError(ErrorCode::kNotFound, "profile: expected none, 4g, 3g or crowded, found {}",
                       name);
    }
    WAYMARK_TRY_ASSIGN(Measured measured, MeasureOn(*star, *profile, walk, flags));
    Print(name, measured);
  }
  return {};
}

}  // namespace
}  // namespace waymark::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Where the time of a localisation goes on a phone's network. A real server and gateway "
      "stand\n"
      "in one network namespace, the phone in another; needs root.\n"
      "  network_bench DATA/kitti_clip_2 --profiles 4g 3g",
      "network_bench");
  waymark::bench::Flags flags;
  app.add_option("drive", flags.drive, "kapture folder with truth.tum")->required();
  app.add_option("--profiles", flags.profiles, "none, 4g, 3g, crowded")->capture_default_str();
  app.add_option("--seconds", flags.seconds, "of each measurement")->capture_default_str();
  app.add_option("--interval", flags.interval_s, "seconds between keyframes")
      ->capture_default_str();
  app.add_flag("--direct", flags.is_direct, "the phone speaks DDS to the server");
  app.add_flag("--as-taken", flags.is_as_taken, "every pixel travels, whatever the network");
  app.add_option("--scratch", flags.scratch, "where the map is kept")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const auto outcome = waymark::bench::Run(flags);
  if (!outcome) fmt::print(stderr, "network_bench: {}\n", ToString(outcome.error()));
  return outcome.ok() ? 0 : 1;
}
