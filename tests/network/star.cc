// SPDX-License-Identifier: Apache-2.0
#include "tests/network/star.h"

#include "mapping/base/process.h"

namespace waymark::network {
namespace {

Result<std::unique_ptr<Program>> StartIn(const NetworkNamespace& inside,
                                         const std::vector<std::string>& words,
                                         const std::filesystem::path& log) {
  WAYMARK_TRY_ASSIGN(Program program, Program::Start(inside, words, log));
  return std::make_unique<Program>(std::move(program));
}

}  // namespace

Result<std::unique_ptr<Star>> Star::Start(const std::filesystem::path& folder,
                                          std::vector<std::string> server,
                                          const std::string& gateway, std::uint64_t seed) {
  std::unique_ptr<Star> star(new Star());
  star->folder_ = folder;
  WAYMARK_TRY_ASSIGN(star->emulator_, Emulator::Create(seed));
  WAYMARK_TRY(star->emulator_->AddHost(*FindProfile("none")));
  WAYMARK_TRY(star->MakeKeys());
  star->server_words_ = std::move(server);
  star->gateway_words_ = {gateway,         "--server",
                          kAddress,        "--listen",
                          "0.0.0.0",
                          "--insecure",  // nobody else reaches the namespaces
                          "--port",        std::to_string(kPort),
                          "--certificate", star->Authority(),
                          "--key",         (folder / "gateway.key").string()};
  WAYMARK_TRY(star->RestartServer());
  WAYMARK_TRY(star->RestartGateway());
  return star;
}

Result<void> Star::RestartServer() {
  server_.reset();
  WAYMARK_TRY_ASSIGN(server_,
                     StartIn(emulator_->Inside(kHost), server_words_, folder_ / "server.log"));
  return {};
}

Result<void> Star::RestartGateway() {
  gateway_.reset();
  WAYMARK_TRY_ASSIGN(gateway_,
                     StartIn(emulator_->Inside(kHost), gateway_words_, folder_ / "gateway.log"));
  return {};
}

Result<void> Star::MakeKeys() const {
  WAYMARK_TRY_ASSIGN(
      const ProgramOutcome made,
      CaptureProgram({"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                      "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj",
                      "/CN=localhost", "-addext", std::string("subjectAltName=IP:") + kAddress,
                      "-keyout", (folder_ / "gateway.key").string(), "-out", Authority()}));
  if (made.status == 0) return {};
  return MakeError(ErrorCode::kUnavailable, "openssl: {}", made.output);
}

}  // namespace waymark::network
