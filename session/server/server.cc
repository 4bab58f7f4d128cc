// SPDX-License-Identifier: Apache-2.0
#include "session/server/server.h"

#include <utility>

#include "session/server/internal/server_loop.h"

namespace waymark::session {

Server::Server(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
Server::~Server() { loop_->Stop(); }

Result<std::unique_ptr<Server>> Server::Start(const ServerOptions& options, ServerParts parts) {
  WAYMARK_TRY(options.Validate());
  auto loop = std::make_unique<Loop>(options, std::move(parts));
  WAYMARK_TRY(loop->Start(options));
  return std::unique_ptr<Server>(new Server(std::move(loop)));
}

void Server::Swap(ServedRelease served) { loop_->Swap(std::move(served)); }
ServerCounters Server::Stop() { return loop_->Stop(); }

}  // namespace waymark::session
