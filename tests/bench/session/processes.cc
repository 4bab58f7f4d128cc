// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/processes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <initializer_list>
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

/// Signals that this thread, and those made from now on, are not ended by.
sigset_t Hold(std::initializer_list<int> signals) {
  sigset_t held;
  ::sigemptyset(&held);
  for (const int signal : signals) ::sigaddset(&held, signal);
  ::pthread_sigmask(SIG_BLOCK, &held, nullptr);
  return held;
}

/// Which of them comes first.
int Await(const sigset_t& held) {
  int came = 0;
  ::sigwait(&held, &came);
  return came;
}

}  // namespace

int RunServer(const std::string& recording, const CityAnchors& anchors, int slices) {
  const sigset_t held = Hold({SIGUSR1, SIGTERM});
  session::ServerOptions options{.dds_domain = -1, .slices = slices, .recording_file = recording};
  const std::filesystem::path folder =
      support::TemporaryRoot() / fmt::format("waymark-session-bench-{}", ::getpid());
  const bool is_city = anchors.count > 0;
  if (is_city) {
    std::filesystem::create_directories(folder);
    (void)StoreCity(anchors, folder / "anchors.db");
  }
  const auto release_of = [&](std::uint64_t epoch) {
    return is_city ? CityRelease(anchors.edge_m, epoch) : session::support::MakeRelease(epoch);
  };
  const auto server = session::support::StartOnFreeDomain(options, [&]() -> session::ServerParts {
    std::unique_ptr<content::AnchorStore> store;
    if (is_city) {
      store = *content::OpenSqliteStore(folder / "anchors.db");
    } else {
      store = std::make_unique<waymark::support::MemoryAnchorStore>();
    }
    return session::support::MakeParts(release_of(1), std::move(store));
  });
  if (!server) return 1;
  fmt::print("{}\n", options.dds_domain);
  std::fflush(stdout);
  for (std::uint64_t epoch = 2; Await(held) == SIGUSR1; ++epoch) {
    const mapping::Release release = release_of(epoch);
    server->Swap({release, session::support::BelievePrior(release)});
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  ::_exit(0);
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

int RunDevices(int domain, int count, int first, int slices) {
  const sigset_t join = Hold({SIGUSR1});
  const auto crowd = BusCrowd::Connect({.domain = domain,
                                        .phones = count,
                                        .first_phone = first,
                                        .room = fmt::format("room-{}", first),
                                        .slices = slices,
                                        .per_participant = 1});
  if (!crowd) return 1;
  fmt::print("{}\n", kDevicesAreMade);
  std::fflush(stdout);
  (void)Await(join);
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
