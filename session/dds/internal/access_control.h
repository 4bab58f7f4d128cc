// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "session/dds/guard.h"
#include "session/dds/internal/strangers.h"
#include "session/dds/log_budget.h"

struct dds_security_access_control;           // Cyclone's
struct dds_security_access_control_listener;  // Cyclone's

namespace waymark::session::dds::internal {

/// Cyclone's own access control, asked once more for each participant that it would let in. Cyclone
/// takes it for a plug-in, which it finds in the program itself. Thread-safe.
class AccessControl {
 public:
  explicit AccessControl(Guard::IdentityOf identity_of) : identity_of_(std::move(identity_of)) {}

  /// What to tell Cyclone of the plug-in. Its path is that of the program: "file://" is cut off,
  /// and dlopen takes the rest, nothing, for the program.
  static constexpr const char* kLibraryPath = "file://";
  static constexpr const char* kInit = "waymark_init_access_control";
  static constexpr const char* kFinalize = "waymark_finalize_access_control";

  /// Which one the plug-in is for that this thread has Cyclone make meanwhile.
  class Scope {
   public:
    explicit Scope(std::shared_ptr<AccessControl> made);
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;
    ~Scope();
  };

  void Refuse(std::set<std::string> names);
  std::set<std::string> PutOut();
  Strangers& strangers() { return strangers_; }

  // For the plug-in, of which each participant has one.
  using Plugin = dds_security_access_control;
  void Attach(Plugin* plugin);
  void Detach(Plugin* plugin);
  void Listen(Plugin* plugin, const dds_security_access_control_listener* listener);
  Guard::Identity IdentityOf(std::string_view certificate_pem) const {
    return identity_of_(certificate_pem);
  }
  bool IsRefused(const std::string& name) const;
  void Remember(Plugin* plugin, std::int64_t permissions, Guard::Identity identity);
  void Forget(Plugin* plugin, std::int64_t permissions);
  /// Somebody who is here, writes or reads what it may not.
  void TellOfTrespass(Plugin* plugin, std::int64_t permissions, const char* does,
                      const char* topic) noexcept;

 private:
  struct Present {
    Guard::Identity identity;
    std::optional<std::chrono::steady_clock::time_point> told = std::nullopt;  // of a trespass
  };

  const Guard::IdentityOf identity_of_;
  Strangers strangers_;
  LogBudget log_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::map<Plugin*, const dds_security_access_control_listener*> listeners_;  // null: none yet
  std::set<std::string> refused_;
  std::map<std::pair<Plugin*, std::int64_t>, Present> present_;  // by handles of permissions
};

}  // namespace waymark::session::dds::internal
