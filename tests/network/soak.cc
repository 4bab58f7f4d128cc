// SPDX-License-Identifier: Apache-2.0
// Phones come and die for as long as asked; server and gateway shall neither grow nor keep what was
// theirs. Exit status 0: they do not; 77: networks cannot be emulated here.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <filesystem>
#include <random>
#include <thread>
#include <vector>

#include "mapping/base/time.h"
#include "tests/network/star.h"
#include "tests/support/temporary_root.h"

namespace waymark::network {
namespace {

using Clock = std::chrono::steady_clock;

struct Flags {
  double seconds = 30, minutes = 0;
  int phones = 8;
  double life_s = 4;
  std::uint64_t seed = 1;
};

struct Sample {
  double at_s = 0;
  double server_mib = 0, gateway_mib = 0;
  int server_open = 0, gateway_open = 0;
};

class Soak {
 public:
  Soak(Star& star, std::filesystem::path folder, const Flags& flags)
      : star_(star), folder_(std::move(folder)), flags_(flags), random_(flags.seed) {}

  Result<void> Run() {
    for (const char* profile : {"none", "4g", "3g", "4g"}) {
      WAYMARK_TRY_ASSIGN(const int host, star_.emulator().AddHost(*FindProfile(profile)));
      hosts_.push_back(host);
    }
    const double seconds = flags_.minutes > 0 ? 60 * flags_.minutes : flags_.seconds;
    const double sample_s = std::max(2.0, seconds / 20);
    const Clock::time_point begin = Clock::now();
    fmt::print("{:>6} {:>7} {:>11} {:>11} {:>12} {:>12}\n", "s", "phones", "server MiB",
               "gateway MiB", "server open", "gateway open");
    for (int i = 0; Seconds(Clock::now() - begin) < seconds; ++i) {
      WAYMARK_TRY(Churn());
      const double now_s = Seconds(Clock::now() - begin);
      if (now_s >= sample_s * static_cast<double>(samples_.size())) Take(now_s);
      std::this_thread::sleep_for(std::chrono::duration<double>(flags_.life_s / flags_.phones));
    }
    phones_.clear();
    // A killed phone's connection is given up after 8 s of silence, and lingers.
    std::this_thread::sleep_for(std::chrono::seconds(12));
    Take(Seconds(Clock::now() - begin));
    return {};
  }

  /// Whether all that phones brought has gone with them, and memory no longer grows.
  bool HasHeld() const {
    const Sample& first = samples_.front();
    const Sample& last = samples_.back();
    const Sample& middle = samples_[samples_.size() / 2];
    const bool is_closed =
        last.server_open <= first.server_open + 2 && last.gateway_open <= first.gateway_open + 2;
    // What the allocator keeps of the first crowd is no growth.
    const auto is_flat = [](double before, double after) { return after <= 1.25 * before + 4; };
    return is_closed && is_flat(middle.server_mib, last.server_mib) &&
           is_flat(middle.gateway_mib, last.gateway_mib);
  }

  int lives() const { return lives_; }

 private:
  /// One phone comes and, when there are enough, the oldest dies.
  Result<void> Churn() {
    if (samples_.empty()) Take(0);
    if (phones_.size() >= static_cast<std::size_t>(flags_.phones)) phones_.pop_front();
    const int host = hosts_[random_() % hosts_.size()];
    WAYMARK_TRY_ASSIGN(Program phone,
                       Program::Start(star_.emulator().Inside(host),
                                      {NETWORK_PEER, "phone", star_.Url(), star_.Authority(),
                                       fmt::format("phone {}", ++lives_)},
                                      folder_ / "phones.log"));
    phones_.push_back(std::move(phone));
    return {};
  }

  void Take(double at_s) {
    const Sample& s =
        samples_.emplace_back(Sample{at_s, star_.server().MemoryMib(), star_.gateway().MemoryMib(),
                                     star_.server().Descriptors(), star_.gateway().Descriptors()});
    fmt::print("{:>6.0f} {:>7} {:>11.1f} {:>11.1f} {:>12} {:>12}\n", at_s, phones_.size(),
               s.server_mib, s.gateway_mib, s.server_open, s.gateway_open);
    std::fflush(stdout);
  }

  Star& star_;
  const std::filesystem::path folder_;
  const Flags flags_;
  std::mt19937_64 random_;
  std::vector<int> hosts_;
  std::deque<Program> phones_;
  std::vector<Sample> samples_;
  int lives_ = 0;
};

int Run(const Flags& flags) {
  if (const auto possible = NetworkNamespace::Create(); !possible) {
    fmt::print("skipped: networks cannot be emulated here: {}\n", possible.error().message);
    return 77;
  }
  const auto folder = support::TemporaryRoot() / ("waymark_soak_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto star = Star::Start(
      folder, {NETWORK_PEER, "server", Star::kAddress, (folder / "anchors.db").string()},
      WAYMARK_GATEWAY);
  if (!star) {
    fmt::print(stderr, "{}\n", ToString(star.error()));
    return 1;
  }
  Soak soak(**star, folder, flags);
  const auto run = soak.Run();
  if (!run) fmt::print(stderr, "{}\n", ToString(run.error()));
  const bool has_held = run.ok() && soak.HasHeld();
  fmt::print("{} phones came and were killed: {}\n", soak.lives(),
             has_held ? "nothing of them is left" : "something of them is left");
  if (run.ok()) std::filesystem::remove_all(folder);
  return has_held ? 0 : 1;
}

}  // namespace
}  // namespace waymark::network

int main(int argc, char** argv) {
  CLI::App app("Phones come and are killed; prints what server and gateway hold meanwhile.",
               "network_soak");
  waymark::network::Flags flags;
  app.add_option("--seconds", flags.seconds, "how long")->capture_default_str();
  app.add_option("--minutes", flags.minutes, "or so long");
  app.add_option("--phones", flags.phones, "at once")->capture_default_str();
  app.add_option("--life", flags.life_s, "seconds that a phone lives")->capture_default_str();
  app.add_option("--seed", flags.seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return waymark::network::Run(flags);
}
