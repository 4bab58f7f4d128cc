// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/processes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include "mapping/base/process.h"
#include "tests/bench/session/bus_crowd.h"
#include "tests/bench/session/peers/web_socket_fan_out.h"
#include "tests/session/session_fixture.h"
#include "tests/support/memory_anchor_store.h"
#include "tests/support/temporary_root.h"

namespace waymark::bench {
namespace {

/// SIGTERM ends it as it ends any process.
int StayUntilTold() {
  while (true) ::pause();
}

void Place(const CityAnchors& anchors, content::AnchorStore& store) {
  constexpr std::size_t kPayloadBytes = 100;
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> along(-anchors.edge_m / 2, anchors.edge_m / 2);
  for (int i = 0; i < anchors.count; ++i) {
    const double x = along(random), y = along(random);
    const auto id = session::UuidFromBits(0xc17, static_cast<std::uint64_t>(i));
    content::AnchorRecord record{.id = AnchorId(session::FormatUuid(id)), .room = RoomId("room0")};
    record.owner = "city";
    record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x, y, 1}};
    record.attachments = {{session::support::kSubmap, {Eigen::Quaterniond::Identity(), {x, y, 0}}}};
    record.kind = "note";
    record.payload = std::string(kPayloadBytes, 'x');
    CHECK(store.Create(record).ok());
  }
}

}  // namespace

int RunServer(const std::string& recording, const CityAnchors& anchors) {
  session::ServerOptions options{.dds_domain = -1, .recording_file = recording};
  const auto server = session::support::StartOnFreeDomain(options, [&] {
    auto store = std::make_unique<waymark::support::MemoryAnchorStore>();
    Place(anchors, *store);
    return session::support::MakeParts(session::support::MakeRelease(), std::move(store));
  });
  if (!server) return 1;
  fmt::print("{}\n", options.dds_domain);
  std::fflush(stdout);
  return StayUntilTold();
}

int RunGateway(int domain, bool is_tls) {
  session::GatewayOptions options{.dds = {.domain = domain}, .max_joins_per_s = 1000};
  const std::filesystem::path folder =
      support::TemporaryRoot() / fmt::format("waymark-session-bench-{}", ::getpid());
  if (is_tls) {
    std::filesystem::create_directories(folder);
    const std::string key = folder / "key.pem", certificate = folder / "certificate.pem";
    const auto made = CaptureProgram(
        {"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
         "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", key, "-out", certificate});
    if (!made || made->status != 0) return 1;
    options.listen.tls = {.certificate_chain_file = certificate, .private_key_file = key};
  }
  const auto gateway = session::Gateway::Start(options);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);  // it has read them
  if (!gateway) return 1;
  fmt::print("{}\n", (*gateway)->port());
  std::fflush(stdout);
  return StayUntilTold();
}

int RunDevices(int domain, int count, int first) {
  sigset_t join;
  ::sigemptyset(&join);
  ::sigaddset(&join, SIGUSR1);
  ::pthread_sigmask(SIG_BLOCK, &join, nullptr);  // as do the threads that are made from now on
  const auto crowd = BusCrowd::Connect(
      {.domain = domain, .phones = count, .first_phone = first, .per_participant = 1});
  if (!crowd) return 1;
  fmt::print("{}\n", kDevicesAreMade);
  std::fflush(stdout);
  int signal = 0;
  ::sigwait(&join, &signal);
  if (!(*crowd)->JoinAll().ok()) return 1;
  fmt::print("{}\n", kDevicesHaveJoined);
  std::fflush(stdout);
  while (true) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    if (!(*crowd)->JoinAll().ok()) return 1;  // says that they are here
  }
}

int RunFanOut() {
  FanOut fan_out;
  const auto port = fan_out.Listen();
  if (!port) return 1;
  fmt::print("{}\n", *port);
  std::fflush(stdout);
  return StayUntilTold();
}

}  // namespace waymark::bench
