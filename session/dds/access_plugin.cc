// SPDX-License-Identifier: Apache-2.0
#include "session/dds/internal/access_control.h"

// Left out of what follows: C++ does not take it, and only its pointer is handed on.
#define DDSI_DOMAINGV_H
struct ddsi_domaingv;

#include <dds/ddsrt/dynlib.h>
#include <dds/security/dds_security_api.h>
extern "C" {  // which this header forgets
#include <dds/security/core/dds_security_utils.h>
}

#include <exception>
#include <utility>

#include "mapping/base/log.h"

namespace waymark::session::dds::internal {
namespace {

using Plugin = dds_security_access_control;

thread_local std::shared_ptr<AccessControl> in_the_making;

/// Cyclone's plug-in, of which we answer some calls first.
struct Original {
  ddsrt_dynlib_t library = nullptr;
  int (*finalize)(void*) = nullptr;
  DDS_Security_access_control_validate_remote_permissions validate = nullptr;
  DDS_Security_access_control_check_remote_participant check_participant = nullptr;
  DDS_Security_access_control_check_remote_datawriter check_writer = nullptr;
  DDS_Security_access_control_check_remote_datareader check_reader = nullptr;
  DDS_Security_access_control_set_listener set_listener = nullptr;
  DDS_Security_access_control_return_permissions_handle return_handle = nullptr;
  std::shared_ptr<AccessControl> ours;
};

/// Calls name the plug-in and nothing else, so what is ours is found by it.
struct Originals {
  std::mutex mutex;
  std::map<const void*, std::shared_ptr<const Original>> by_plugin;  // guarded by mutex

  std::shared_ptr<const Original> Of(const void* plugin) {
    const std::lock_guard lock(mutex);
    return by_plugin.at(plugin);
  }
};

/// Never destroyed: Cyclone may have threads for as long as the process lives.
Originals& TheOriginals() {
  static Originals& originals = *new Originals;
  return originals;
}

std::string_view CertificateIn(const DDS_Security_AuthenticatedPeerCredentialToken& credentials) {
  const DDS_Security_Property_t* const found =
      DDS_Security_DataHolder_find_property(&credentials, "c.id");
  return found == nullptr || found->value == nullptr ? "" : found->value;
}

DDS_Security_PermissionsHandle Validate(
    Plugin* plugin, const dds_security_authentication* authentication,
    DDS_Security_IdentityHandle local, DDS_Security_IdentityHandle remote,
    const DDS_Security_PermissionsToken* permissions,
    const DDS_Security_AuthenticatedPeerCredentialToken* credentials,
    DDS_Security_SecurityException* why) noexcept try {
  const auto original = TheOriginals().Of(plugin);
  Guard::Identity identity = original->ours->IdentityOf(CertificateIn(*credentials));
  if (identity.name.empty() || original->ours->IsRefused(identity.name)) {
    DDS_Security_Exception_set(why, "waymark", DDS_SECURITY_ERR_ACCESS_DENIED_CODE, 0,
                               "credentials of \"%s\": were revoked", identity.name.c_str());
    return 0;
  }
  const auto handle =
      original->validate(plugin, authentication, local, remote, permissions, credentials, why);
  if (handle != 0) {
    original->ours->Remember(plugin, handle, std::move(identity));
  } else {  // the reason does not say whose
    const std::string reason = why->message == nullptr ? "" : why->message;
    DDS_Security_Exception_reset(why);
    DDS_Security_Exception_set(why, "waymark", DDS_SECURITY_ERR_ACCESS_DENIED_CODE, 0,
                               "permissions of \"%s\": %s", identity.name.c_str(), reason.c_str());
  }
  return handle;
} catch (const std::exception& exception) {
  DDS_Security_Exception_set(why, "waymark", DDS_SECURITY_ERR_ACCESS_DENIED_CODE, 0, "%s",
                             exception.what());
  return 0;
}

DDS_Security_boolean CheckParticipant(
    Plugin* plugin, DDS_Security_PermissionsHandle handle, DDS_Security_DomainId domain,
    const DDS_Security_ParticipantBuiltinTopicDataSecure* participant,
    DDS_Security_SecurityException* why) noexcept {
  const auto original = TheOriginals().Of(plugin);
  const auto may = original->check_participant(plugin, handle, domain, participant, why);
  const auto& key = participant->key;
  if (may) original->ours->strangers().Admit({key[0], key[1], key[2]});
  return may;
}

DDS_Security_boolean CheckWriter(Plugin* plugin, DDS_Security_PermissionsHandle handle,
                                 DDS_Security_DomainId domain,
                                 const DDS_Security_PublicationBuiltinTopicDataSecure* writer,
                                 DDS_Security_SecurityException* why) noexcept {
  const auto original = TheOriginals().Of(plugin);
  const auto may = original->check_writer(plugin, handle, domain, writer, why);
  if (!may) original->ours->TellOfTrespass(plugin, handle, "writes", writer->topic_name);
  return may;
}

DDS_Security_boolean CheckReader(Plugin* plugin, DDS_Security_PermissionsHandle handle,
                                 DDS_Security_DomainId domain,
                                 const DDS_Security_SubscriptionBuiltinTopicDataSecure* reader,
                                 DDS_Security_boolean* is_relay,
                                 DDS_Security_SecurityException* why) noexcept {
  const auto original = TheOriginals().Of(plugin);
  const auto may = original->check_reader(plugin, handle, domain, reader, is_relay, why);
  if (!may) original->ours->TellOfTrespass(plugin, handle, "reads", reader->topic_name);
  return may;
}

DDS_Security_boolean ReturnHandle(Plugin* plugin, DDS_Security_PermissionsHandle handle,
                                  DDS_Security_SecurityException* why) noexcept {
  const auto original = TheOriginals().Of(plugin);
  original->ours->Forget(plugin, handle);
  return original->return_handle(plugin, handle, why);
}

DDS_Security_boolean SetListener(Plugin* plugin,
                                 const dds_security_access_control_listener* listener,
                                 DDS_Security_SecurityException* why) noexcept {
  const auto original = TheOriginals().Of(plugin);
  original->ours->Listen(plugin, listener);
  return original->set_listener(plugin, listener, why);
}

template <typename Function>
bool Find(ddsrt_dynlib_t library, const char* name, Function& function) {
  void* address = nullptr;
  if (ddsrt_dlsym(library, name, &address) != DDS_RETCODE_OK) return false;
  function = reinterpret_cast<Function>(address);
  return true;
}

int Init(const char* argument, void** context, struct ddsi_domaingv* domain) {
  auto original = std::make_shared<Original>();
  original->ours = in_the_making;
  int (*init)(const char*, void**, struct ddsi_domaingv*) = nullptr;
  if (original->ours == nullptr ||
      ddsrt_dlopen("dds_security_ac", true, &original->library) != DDS_RETCODE_OK) {
    return -1;
  }
  if (!Find(original->library, "init_access_control", init) ||
      !Find(original->library, "finalize_access_control", original->finalize) ||
      init(argument, context, domain) != 0) {
    (void)ddsrt_dlclose(original->library);
    return -1;
  }
  auto* const plugin = static_cast<Plugin*>(*context);
  original->validate = std::exchange(plugin->validate_remote_permissions, &Validate);
  original->check_participant = std::exchange(plugin->check_remote_participant, &CheckParticipant);
  original->check_writer = std::exchange(plugin->check_remote_datawriter, &CheckWriter);
  original->check_reader = std::exchange(plugin->check_remote_datareader, &CheckReader);
  original->set_listener = std::exchange(plugin->set_listener, &SetListener);
  original->return_handle = std::exchange(plugin->return_permissions_handle, &ReturnHandle);
  original->ours->Attach(plugin);
  Originals& all = TheOriginals();
  const std::lock_guard lock(all.mutex);
  all.by_plugin.insert_or_assign(plugin, std::move(original));
  return 0;
}

int Finalize(void* context) {
  Originals& all = TheOriginals();
  const auto original = all.Of(context);
  original->ours->Detach(static_cast<Plugin*>(context));
  const int result = original->finalize(context);  // what is left of it may still call us
  {
    const std::lock_guard lock(all.mutex);
    all.by_plugin.erase(context);
  }
  (void)ddsrt_dlclose(original->library);
  return result;
}

}  // namespace

AccessControl::Scope::Scope(std::shared_ptr<AccessControl> made) {
  in_the_making = std::move(made);
}
AccessControl::Scope::~Scope() { in_the_making.reset(); }

}  // namespace waymark::session::dds::internal

// Cyclone finds these by name in the program (session/server/CMakeLists.txt exports them).
extern "C" {

__attribute__((visibility("default"))) int waymark_init_access_control(
    const char* argument, void** context, struct ddsi_domaingv* domain) noexcept {
  try {
    return waymark::session::dds::internal::Init(argument, context, domain);
  } catch (const std::exception& exception) {
    waymark::LogError("DDS: access control: {}", exception.what());
    return -1;
  }
}

__attribute__((visibility("default"))) int waymark_finalize_access_control(void* context) noexcept {
  return waymark::session::dds::internal::Finalize(context);
}

}  // extern "C"
