// SPDX-License-Identifier: Apache-2.0
// waymark-gateway: brings phones on any network to a waymark-serve, until it is told to end.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <string>

#include "mapping/base/log.h"
#include "session/gateway/gateway.h"
#include "session/tools/end_signals.h"
#include "session/tools/security.h"

namespace waymark::session {
namespace {

struct Arguments {
  std::string security;
  bool is_insecure_wanted = false;
  GatewayOptions gateway;
};

void ParseArguments(CLI::App& app, Arguments& arguments) {
  GatewayOptions& options = arguments.gateway;
  app.footer(
      "Examples:\n"
      "  waymark-gateway --listen 0.0.0.0 --port 8443 --certificate chain.pem --key key.pem \\\n"
      "                  --security KEYS\n"
      "  waymark-gateway --listen 127.0.0.1 --port 8080           without TLS, for trials\n"
      "Phones then join wss://HOST:8443 or ws://127.0.0.1:8080 (waymark-phone --server).");
  app.add_option("--listen", options.listen.address, "address that phones connect to")
      ->capture_default_str();
  app.add_option("--port", options.listen.port, "0: any free one")->capture_default_str();
  CLI::Option* const certificate =
      app.add_option("--certificate", options.listen.tls.certificate_chain_file,
                     "PEM, the server's own first; without it connections are not encrypted");
  certificate->needs(
      app.add_option("--key", options.listen.tls.private_key_file, "PEM")->needs(certificate));
  app.add_option("--security", arguments.security,
                 "folder of waymark-keys: phones must show a token at the door; one of "
                 "`waymark-keys issue` also authenticates the gateway to the server");
  app.add_flag("--insecure", arguments.is_insecure_wanted,
               "serve beyond this machine without keys or without TLS");
  app.add_option("--server", options.dds.server, "host or address of waymark-serve")
      ->capture_default_str();
  app.add_option("--domain", options.dds.domain, "its DDS domain, 0 to 230")->capture_default_str();
  app.add_option("--slices", options.slices, "into how many it cuts its bus")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "that carry connections")->capture_default_str();
  app.add_option("--max-phones", options.max_phones, "at once; others are sent away")
      ->capture_default_str();
  app.add_option("--max-messages", options.max_messages_per_s,
                 "of a phone in a second; what is beyond is dropped")
      ->capture_default_str();
  app.add_option("--max-joins", options.max_joins_per_s,
                 "of an address in a second, ten times as many at once; others are sent away")
      ->capture_default_str();
}

/// A door that others can reach is not left open by oversight.
Result<void> CheckSecurity(const Arguments& arguments) {
  const socket::ListenOptions& listen = arguments.gateway.listen;
  if (IsLoopback(listen.address) || arguments.is_insecure_wanted) return {};
  if (!arguments.security.empty() && !listen.tls.certificate_chain_file.empty()) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "listen {}: others can reach it; expected --security KEYS and --certificate "
                   "with --key, or --insecure",
                   listen.address);
}

Result<void> Run(Arguments arguments, const sigset_t& end_signals) {
  WAYMARK_TRY(CheckSecurity(arguments));
  GatewayOptions& options = arguments.gateway;
  if (!arguments.security.empty()) {
    WAYMARK_TRY_ASSIGN(options.door, keys::TokenDoor::Open({.folder = arguments.security}));
    if (HasDdsCredentials(arguments.security)) options.dds.security_folder = arguments.security;
  }
  keys::ExpiryWatch expiry(options.dds.security_folder, "gateway");
  WAYMARK_TRY(expiry.CheckNow(keys::WallNow()));
  WAYMARK_TRY_ASSIGN(const auto gateway, Gateway::Start(options));
  const bool is_open = options.listen.tls.certificate_chain_file.empty();
  fmt::print("ready pid={} address={} port={} tls={} tokens={} server={} domain={}\n", ::getpid(),
             options.listen.address, gateway->port(), is_open ? "no" : "yes",
             options.door ? "yes" : "no", options.dds.server, options.dds.domain);
  std::fflush(stdout);
  AwaitSignal(end_signals, [&] { WarnOfExpiry(expiry); });
  fmt::print("ended: {}\n", ToString(gateway->Stop()));
  return {};
}

}  // namespace
}  // namespace waymark::session

int main(int argc, char** argv) {
  const sigset_t end_signals = waymark::session::BlockEndSignals();
  CLI::App app{"Brings phones on any network to a server: binary WebSockets, with TLS.",
               "waymark-gateway"};
  waymark::session::Arguments arguments;
  waymark::session::ParseArguments(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const auto outcome = waymark::session::Run(std::move(arguments), end_signals);
  if (outcome.ok()) return 0;
  waymark::LogError("{}", waymark::ToString(outcome.error()));
  return 1;
}
