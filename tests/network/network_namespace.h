// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::network {

/// A network of its own in the kernel, with nothing in it but a loopback that is up. It goes when
/// this object and everything started in it are gone. Needs root.
class NetworkNamespace {
 public:
  /// Errors: Unavailable, with what is missing.
  static Result<NetworkNamespace> Create();
  NetworkNamespace(NetworkNamespace&& other) noexcept;
  NetworkNamespace& operator=(NetworkNamespace&& other) noexcept;
  ~NetworkNamespace();

  /// Runs this inside and waits. Sockets, threads and processes made meanwhile stay inside.
  void Run(const std::function<void()>& body) const;
  /// Runs a program inside. Errors: Unavailable, with what it complained of.
  Result<void> Run(const std::vector<std::string>& words) const;

  /// A device inside that hands each IP packet, as it is, to whoever holds the file descriptor.
  /// Errors: Unavailable.
  Result<int> OpenTun(const std::string& name) const;
  /// The device has this address alone from now on, and is up. Errors: Unavailable.
  Result<void> SetAddress(const std::string& device, const std::string& address,
                          const std::string& mask) const;

  /// A path that names it for programs such as ip.
  std::string Path() const;

 private:
  explicit NetworkNamespace(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace waymark::network
