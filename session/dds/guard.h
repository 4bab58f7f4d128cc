// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>

namespace waymark::session::dds {

namespace internal {
class AccessControl;
}

/// Keeps others off a participant with DDS Security although their credentials are good: Cyclone
/// knows a revocation list only as it was when the participant was made. May serve several at a
/// time. Thread-safe.
class Guard {
 public:
  /// Whom a certificate is for, and when it ends. Nobody comes without a name.
  struct Identity {
    std::string name;
    std::chrono::sys_seconds until{};
  };
  /// What a certificate in PEM says; called on DDS threads, of certificates that are genuine.
  using IdentityOf = std::function<Identity(std::string_view certificate_pem)>;

  explicit Guard(IdentityOf identity_of);
  ~Guard();

  /// Nobody of these names comes any more, nor whoever was refused before and is not among them is
  /// kept out any longer. Those who are here stay until `PutOut`.
  void Refuse(std::set<std::string> names);
  /// Ends the connections of those who are here and refused: they hear and say nothing more.
  /// Returns their names. To be called while the participants live.
  std::set<std::string> PutOut();

  /// Logs who has come and shown no credentials that are good. To be called now and then.
  void TellOfStrangers();

 private:
  friend class Participant;

  std::shared_ptr<internal::AccessControl> access_control_;
};

}  // namespace waymark::session::dds
