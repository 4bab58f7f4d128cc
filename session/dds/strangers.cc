// SPDX-License-Identifier: Apache-2.0
#include "session/dds/internal/strangers.h"

#include <arpa/inet.h>
#include <dds/dds.h>

#include <cstring>
#include <exception>
#include <memory>

#include "mapping/base/log.h"

namespace waymark::session::dds::internal {
namespace {

Strangers::Prefix PrefixOf(const dds_guid_t& guid) {
  Strangers::Prefix prefix{};
  std::memcpy(prefix.data(), guid.v, sizeof prefix);
  for (std::uint32_t& word : prefix) word = ntohl(word);
  return prefix;
}

void OnParticipants(dds_entity_t reader, void* self) noexcept try {
  auto& strangers = *static_cast<Strangers*>(self);
  constexpr int kAtOnce = 32;
  void* samples[kAtOnce] = {};
  dds_sample_info_t infos[kAtOnce];
  dds_return_t count = 0;
  do {
    count = dds_take(reader, samples, infos, kAtOnce, kAtOnce);
    for (int i = 0; i < count; ++i) {
      const auto& participant = *static_cast<const dds_builtintopic_participant_t*>(samples[i]);
      const Strangers::Prefix prefix = PrefixOf(participant.key);
      if (infos[i].instance_state == DDS_ALIVE_INSTANCE_STATE) {
        strangers.Discover(prefix, std::chrono::steady_clock::now());
      } else {
        strangers.Lose(prefix);
      }
    }
    if (count > 0) (void)dds_return_loan(reader, samples, count);
  } while (count == kAtOnce);
} catch (const std::exception& exception) {
  LogError("DDS: a participant was overlooked: {}", exception.what());
}

}  // namespace

void Strangers::WatchFrom(std::int32_t participant) {
  dds_guid_t own{};
  if (dds_get_guid(participant, &own) == DDS_RETCODE_OK) Admit(PrefixOf(own));
  const std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)> listener(
      dds_create_listener(this), &dds_delete_listener);
  dds_lset_data_available(listener.get(), &OnParticipants);
  if (dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener.get()) <
      0) {
    LogWarning("DDS: who comes without credentials will be missing from this log");
  }
}

void Strangers::Discover(const Prefix& prefix, Time now) {
  const std::lock_guard lock(mutex_);
  if (!admitted_.contains(prefix)) waiting_.emplace(prefix, now);
}

void Strangers::Admit(const Prefix& prefix) {
  const std::lock_guard lock(mutex_);
  waiting_.erase(prefix);
  admitted_.insert(prefix);
}

void Strangers::Lose(const Prefix& prefix) {
  const std::lock_guard lock(mutex_);
  waiting_.erase(prefix);
  admitted_.erase(prefix);
}

void Strangers::Tell(Time now) {
  constexpr std::chrono::seconds kPatience{10};
  const std::lock_guard lock(mutex_);
  std::erase_if(waiting_, [&](const auto& entry) {
    const auto& [prefix, since] = entry;
    if (now - since < kPatience) return false;
    if (!log_.Admit(now)) return false;  // later
    LogWarning(
        "DDS participant {:x}:{:x}:{:x}: has shown no credentials that are good here, it hears "
        "and says nothing",
        prefix[0], prefix[1], prefix[2]);
    return true;
  });
}

}  // namespace waymark::session::dds::internal
