// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ssl/context.hpp>

#include "session/socket/channel.h"

namespace waymark::session::socket::internal {

/// TLS 1.2 or later. Errors: InvalidArgument with the file.
Result<std::shared_ptr<boost::asio::ssl::context>> MakeServerContext(const ServerTls& tls);
Result<std::shared_ptr<boost::asio::ssl::context>> MakeClientContext(const ClientTls& tls);

}  // namespace waymark::session::socket::internal
