// SPDX-License-Identifier: Apache-2.0
#include "session/dds/internal/access_control.h"

// Left out of what follows: C++ does not take it, and only its pointer is handed on.
#define DDSI_DOMAINGV_H
struct ddsi_domaingv;

#include <dds/security/dds_security_api.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>
#include <vector>

#include "mapping/base/log.h"

namespace waymark::session::dds::internal {
namespace {

std::string Printable(std::string text) {
  text.resize(std::min<std::size_t>(text.size(), 100));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, ' ');
  return text;
}

}  // namespace

void AccessControl::Attach(Plugin* plugin) {
  const std::lock_guard lock(mutex_);
  listeners_.emplace(plugin, nullptr);
}

void AccessControl::Detach(Plugin* plugin) {
  const std::lock_guard lock(mutex_);
  listeners_.erase(plugin);
  std::erase_if(present_, [plugin](const auto& entry) { return entry.first.first == plugin; });
}

void AccessControl::Listen(Plugin* plugin, const dds_security_access_control_listener* listener) {
  const std::lock_guard lock(mutex_);
  listeners_.insert_or_assign(plugin, listener);
}

bool AccessControl::IsRefused(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return refused_.contains(name);
}

void AccessControl::Remember(Plugin* plugin, std::int64_t permissions, Guard::Identity identity) {
  const std::lock_guard lock(mutex_);
  present_.insert_or_assign(std::pair(plugin, permissions), Present{std::move(identity)});
}

// Cyclone ends it by a timer and says nothing.
void AccessControl::Forget(Plugin* plugin, std::int64_t permissions) {
  const std::lock_guard lock(mutex_);
  const auto found = present_.find({plugin, permissions});
  if (found == present_.end()) return;
  const Guard::Identity& identity = found->second.identity;
  if (std::chrono::system_clock::now() >= identity.until) {
    LogWarning("{}: its credentials have ended, and with them its connection to DDS",
               identity.name);
  }
  present_.erase(found);
}

// Cyclone leaves out whose it is, or all of it. The topic's name is the stranger's.
void AccessControl::TellOfTrespass(Plugin* plugin, std::int64_t permissions, const char* does,
                                   const char* topic) noexcept try {
  constexpr std::chrono::seconds kToldAgain{60};
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  const auto found = present_.find({plugin, permissions});
  if (found == present_.end()) return;
  Present& present = found->second;
  if (present.told && now - *present.told < kToldAgain) return;
  if (!log_.Admit(now)) return;
  present.told = now;
  LogWarning("{}: {} \"{}\" where its permissions do not allow it", present.identity.name, does,
             Printable(topic == nullptr ? "" : topic));
} catch (const std::exception&) {  // no memory for a line: nothing to say it with
}

void AccessControl::Refuse(std::set<std::string> names) {
  const std::lock_guard lock(mutex_);
  refused_ = std::move(names);
}

// As when permissions end, which Cyclone's own plug-in tells by the same call.
std::set<std::string> AccessControl::PutOut() {
  struct Call {
    const dds_security_access_control_listener* listener;
    Plugin* plugin;
    std::int64_t handle;
  };
  std::vector<Call> calls;
  std::set<std::string> names;
  std::unique_lock lock(mutex_);
  for (const auto& [key, present] : present_) {
    const auto& [plugin, handle] = key;
    const auto listener = listeners_.find(plugin);
    if (!refused_.contains(present.identity.name)) continue;
    if (listener == listeners_.end() || listener->second == nullptr) continue;
    calls.push_back({listener->second, plugin, handle});
    names.insert(present.identity.name);
  }
  lock.unlock();  // the calls come back with Forget
  for (const Call& call : calls) call.listener->on_revoke_permissions(call.plugin, call.handle);
  return names;
}

}  // namespace waymark::session::dds::internal
