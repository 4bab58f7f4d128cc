// SPDX-License-Identifier: Apache-2.0
#include "tests/network/profiles.h"

#include <algorithm>
#include <array>

namespace waymark::network {
namespace {

using std::chrono::seconds;

// Radio links repair their own losses (HARQ, RLC), so that little loss is left for IP, as delay
// that varies. Their queues are long: a second of buffer is common on 3G.
constexpr std::array kProfiles{
    Profile{.name = "none", .source = "the machine itself", .up = {}, .down = {}},
    Profile{.name = "4g",
            .source = "median LTE rates of Huang et al., MobiSys 2012 (12.7 down, 5.6 up Mbit/s); "
                      "70 ms round trip of WebPageTest's LTE",
            .up = {.delay = milliseconds(35),
                   .jitter = milliseconds(10),
                   .rate_bps = 5.6e6,
                   .queue = milliseconds(300),
                   .loss = 0.005},
            .down = {.delay = milliseconds(35),
                     .jitter = milliseconds(10),
                     .rate_bps = 12.7e6,
                     .queue = milliseconds(300),
                     .loss = 0.005}},
    Profile{.name = "3g",
            .source = "WebPageTest's 3G (1.6 down, 0.768 up Mbit/s, 300 ms round trip)",
            .up = {.delay = milliseconds(150),
                   .jitter = milliseconds(30),
                   .rate_bps = 0.768e6,
                   .queue = milliseconds(1000),
                   .loss = 0.01},
            .down = {.delay = milliseconds(150),
                     .jitter = milliseconds(30),
                     .rate_bps = 1.6e6,
                     .queue = milliseconds(1000),
                     .loss = 0.01}},
    Profile{.name = "crowded",
            .source = "no measurement: 10 to 30 % loss, 2 s outages, packets that overtake",
            .up = {.delay = milliseconds(60),
                   .jitter = milliseconds(30),
                   .rate_bps = 2e6,
                   .queue = milliseconds(500),
                   .loss = 0.1,
                   .worst_loss = 0.3,
                   .overtaking = 0.05,
                   .outage_every = seconds(15),
                   .outage = seconds(2)},
            .down = {.delay = milliseconds(60),
                     .jitter = milliseconds(30),
                     .rate_bps = 4e6,
                     .queue = milliseconds(500),
                     .loss = 0.1,
                     .worst_loss = 0.3,
                     .overtaking = 0.05,
                     .outage_every = seconds(15),
                     .outage = seconds(2)}},
};

}  // namespace

std::span<const Profile> Profiles() { return kProfiles; }

const Profile* FindProfile(std::string_view name) {
  const auto found = std::find_if(kProfiles.begin(), kProfiles.end(),
                                  [&](const Profile& profile) { return profile.name == name; });
  return found == kProfiles.end() ? nullptr : &*found;
}

}  // namespace waymark::network
