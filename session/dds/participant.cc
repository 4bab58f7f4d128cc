// SPDX-License-Identifier: Apache-2.0
#include "session/dds/participant.h"

#include <arpa/inet.h>
#include <dds/dds.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "session/dds/internal/access_control.h"
#include "session/dds/internal/cyclone_log.h"
#include "session/dds/internal/qos.h"

namespace waymark::session::dds {
namespace {

Result<in_addr> ResolveHost(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (code != 0 || found == nullptr) {
    return MakeError(ErrorCode::kNotFound,
                     "server \"{}\": expected a host name or IPv4 address: {}", host,
                     ::gai_strerror(code));
  }
  const in_addr address = reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr;
  ::freeaddrinfo(found);
  return address;
}

std::string AddressText(in_addr address) {
  char text[INET_ADDRSTRLEN] = {};
  ::inet_ntop(AF_INET, &address, text, sizeof text);
  return text;
}

/// The address of ours from which packets to `peer` leave. Nothing is sent.
Result<in_addr> FindLocalAddress(in_addr peer, int port) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return MakeError(ErrorCode::kUnavailable, "no UDP socket to be had");
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr = peer;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t length = sizeof address;
  const bool reachable =
      ::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length) == 0;
  ::close(descriptor);
  if (!reachable) {
    return MakeError(ErrorCode::kUnavailable, "server {}: no network leads there",
                     AddressText(peer));
  }
  return address.sin_addr;
}

/// Whether a UDP socket could be bound there; errno says why not.
bool CanBind(in_addr address, int port) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return false;
  sockaddr_in wanted{};
  wanted.sin_family = AF_INET;
  wanted.sin_addr = address;
  wanted.sin_port = htons(static_cast<std::uint16_t>(port));
  const bool is_bound =
      ::bind(descriptor, reinterpret_cast<const sockaddr*>(&wanted), sizeof wanted) == 0;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return is_bound;
}

/// What DDS would only report as a general failure.
Result<void> CheckServerAddress(const ParticipantOptions& options, in_addr address) {
  if (!CanBind(address, 0)) {
    return MakeError(ErrorCode::kInvalidArgument, "address {}: is not one of this machine: {}",
                     options.server, std::strerror(errno));
  }
  const in_addr any{.s_addr = htonl(INADDR_ANY)};  // as DDS binds
  const int port = ServerPort(options.domain, options.slice);
  if (CanBind(any, port) && CanBind(any, port + 1)) return {};
  return MakeError(ErrorCode::kConflict,
                   "DDS domain {}: UDP ports {} and {} are taken; is another server running there?",
                   options.domain, port, port + 1);
}

// Measured choices. No multicast: discovery stays linear in the number of devices. One receive
// thread: with several, deleting a domain after the address changed hangs. High watermark: a writer
// otherwise blocks all readers while one dead reader waits for its lease. The server's own port as
// its only peer keeps it from probing for neighbours.
std::string ConfigurationXml(const ParticipantOptions& options, const std::string& interface,
                             const std::string& server) {
  const bool is_server = options.role == ParticipantOptions::Role::kServer;
  return fmt::format(
      "<CycloneDDS><Domain id=\"any\"><General><Interfaces>"
      "<NetworkInterface address=\"{}\" multicast=\"false\"/></Interfaces>"
      "<AllowMulticast>false</AllowMulticast></General>"
      "<Discovery><ExternalDomainId>{}</ExternalDomainId>"
      "<ParticipantIndex>{}</ParticipantIndex><Peers><Peer address=\"{}:{}\"/></Peers>"
      "<LeaseDuration>{}</LeaseDuration><SPDPInterval>1 s</SPDPInterval></Discovery>"
      "<Internal><MultipleReceiveThreads>false</MultipleReceiveThreads>"
      "<MaxSampleSize>{} B</MaxSampleSize>"
      "<Watermarks><WhcHigh>256 MB</WhcHigh><WhcHighInit>256 MB</WhcHighInit></Watermarks>"
      "<Test><XmitLossiness>{}</XmitLossiness></Test></Internal></Domain></CycloneDDS>",
      interface, options.domain, is_server ? std::to_string(options.slice) : "none", server,
      ServerPort(options.domain, options.slice), options.lease, options.max_sample_bytes,
      options.transmit_loss_per_mille);
}

/// Domain numbers inside the process are ours to choose; the one on the wire is in the XML. What is
/// secured must be in the range that governance and permissions may name.
Result<std::pair<Entity, dds_domainid_t>> CreateDomain(const std::string& xml, int wire_domain,
                                                       bool is_secure) {
  const dds_domainid_t first = is_secure ? 0 : 1000;
  const dds_domainid_t count = is_secure ? 231 : 4096;
  internal::RouteCycloneLog();
  for (dds_domainid_t id = first; id < first + count; ++id) {
    const dds_entity_t handle = dds_create_domain(id, xml.c_str());
    if (handle == DDS_RETCODE_PRECONDITION_NOT_MET) continue;  // taken
    WAYMARK_TRY_ASSIGN(Entity domain, Entity::Adopt(handle, fmt::format("domain {}", wire_domain)));
    internal::NameDomainInLog(wire_domain);
    return std::pair(std::move(domain), id);
  }
  return MakeError(ErrorCode::kUnavailable, "domain {}: the process already holds {} domains",
                   wire_domain, count);
}

/// The plug-ins are those of Debian's Cyclone; the files are as session/keys names them.
internal::Qos SecurityQos(const std::string& folder, bool is_guarded) {
  internal::Qos qos(dds_create_qos());
  const auto set = [&](const std::string& name, const std::string& value) {
    dds_qset_prop(qos.get(), ("dds.sec." + name).c_str(), value.c_str());
  };
  const auto set_library = [&](const std::string& kind, const std::string& path,
                               const std::string& init, const std::string& finalize) {
    set(kind + ".library.path", path);
    set(kind + ".library.init", init);
    set(kind + ".library.finalize", finalize);
  };
  const auto set_file = [&](const std::string& name, const std::string& file) {
    set(name, "file:" + folder + "/" + file);
  };
  set_library("auth", "dds_security_auth", "init_authentication", "finalize_authentication");
  set_library("crypto", "dds_security_crypto", "init_crypto", "finalize_crypto");
  if (is_guarded) {
    using internal::AccessControl;
    set_library("access", AccessControl::kLibraryPath, AccessControl::kInit,
                AccessControl::kFinalize);
  } else {
    set_library("access", "dds_security_ac", "init_access_control", "finalize_access_control");
  }
  set_file("auth.identity_ca", "identity_ca.pem");
  set_file("auth.identity_certificate", "certificate.pem");
  set_file("auth.private_key", "key.pem");
  set_file("access.permissions_ca", "permissions_ca.pem");
  set_file("access.governance", "governance.p7s");
  set_file("access.permissions", "permissions.p7s");
  return qos;
}

/// What DDS would only say in its trace.
Result<void> CheckSecurityFolder(const std::string& folder) {
  for (const char* const name : {"identity_ca.pem", "certificate.pem", "key.pem",
                                 "permissions_ca.pem", "governance.p7s", "permissions.p7s"}) {
    if (::access((folder + "/" + name).c_str(), R_OK) == 0) continue;
    return MakeError(ErrorCode::kNotFound,
                     "{}/{}: expected what `waymark-keys issue` makes for DDS Security: {}", folder,
                     name, std::strerror(errno));
  }
  return {};
}

}  // namespace

Result<void> ParticipantOptions::Validate() const {
  if (domain < 0 || domain > 230) {
    return MakeError(ErrorCode::kInvalidArgument, "DDS domain: expected [0, 230], found {}",
                     domain);
  }
  if (slice < 0 || slice >= kMaxSlices) {
    return MakeError(ErrorCode::kInvalidArgument, "slice: expected [0, {}], found {}",
                     kMaxSlices - 1, slice);
  }
  if (transmit_loss_per_mille < 0 || transmit_loss_per_mille > 999) {
    return MakeError(ErrorCode::kInvalidArgument, "transmit loss: expected [0, 999], found {}",
                     transmit_loss_per_mille);
  }
  if (guard && security_folder.empty()) {
    return MakeError(ErrorCode::kInvalidArgument, "guard: expected a security folder beside it");
  }
  return {};
}

// As DDSI numbers them: 250 to a domain, two to a participant.
int ServerPort(int domain, int slice) { return 7400 + 250 * domain + 10 + 2 * slice; }

Result<Participant> Participant::Create(const ParticipantOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(const in_addr server, ResolveHost(options.server));
  in_addr interface = server;
  if (options.role == ParticipantOptions::Role::kServer) {
    WAYMARK_TRY(CheckServerAddress(options, server));
  } else {
    WAYMARK_TRY_ASSIGN(interface,
                       FindLocalAddress(server, ServerPort(options.domain, options.slice)));
  }
  const std::string xml = ConfigurationXml(options, AddressText(interface), AddressText(server));
  const bool is_secure = !options.security_folder.empty();
  if (is_secure) WAYMARK_TRY(CheckSecurityFolder(options.security_folder));
  WAYMARK_TRY_ASSIGN(auto domain, CreateDomain(xml, options.domain, is_secure));
  const auto qos =
      is_secure ? SecurityQos(options.security_folder, options.guard != nullptr) : nullptr;
  const internal::AccessControl::Scope scope(options.guard ? options.guard->access_control_
                                                           : nullptr);
  const dds_entity_t handle = dds_create_participant(domain.second, qos.get(), nullptr);
  WAYMARK_TRY_ASSIGN(
      Entity participant,
      Entity::Adopt(handle, is_secure ? fmt::format("DDS domain {} with the credentials of {}",
                                                    options.domain, options.security_folder)
                                      : fmt::format("DDS domain {}", options.domain)));
  if (options.guard) {
    options.guard->access_control_->strangers().WatchFrom(participant.handle());
  }
  return Participant(std::move(domain.first), std::move(participant));
}

Result<std::int32_t> Participant::FindOrCreateTopic(const std::string& name,
                                                    const void* descriptor) {
  const std::lock_guard lock(*mutex_);
  if (const auto found = topics_.find(name); found != topics_.end()) return found->second.handle();
  WAYMARK_TRY_ASSIGN(
      Entity topic,
      Entity::Adopt(
          dds_create_topic(handle(), static_cast<const dds_topic_descriptor_t*>(descriptor),
                           name.c_str(), nullptr, nullptr),
          name));
  const std::int32_t topic_handle = topic.handle();
  topics_.emplace(name, std::move(topic));
  return topic_handle;
}

}  // namespace waymark::session::dds
