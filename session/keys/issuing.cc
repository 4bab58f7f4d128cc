// SPDX-License-Identifier: Apache-2.0
// What servers, gateways and devices are given, and what is taken from them again.
#include "mapping/base/file.h"
#include "session/keys/authority.h"
#include "session/keys/dds_documents.h"
#include "session/keys/revocations.h"
#include "session/state/messages.h"

namespace waymark::session::keys {
namespace {

namespace fs = std::filesystem;
using Kind = Authority::Request::Kind;

/// The partitions are those of session/wire. A device speaks where nobody else may, and hears its
/// room and what is said to it alone.
Grant MakeGrant(const Authority::Request& request, const std::string& subject) {
  Grant grant{.subject = subject, .validity = request.validity, .writes = {}, .reads = {}};
  switch (request.kind) {
    case Kind::kServer:
      grant.writes = grant.reads = {"*"};
      break;
    case Kind::kGateway:  // for all devices, and never in the server's name
      grant.writes = {"room.*.up.gateway", "gateways.up"};
      grant.reads = {"room.*.down", "room.*.device.*", "gateways.down"};
      break;
    case Kind::kDevice:
      grant.writes = {"room." + request.room + ".up." + request.name};
      grant.reads = {"room." + request.room + ".down",
                     "room." + request.room + ".device." + request.name};
      break;
  }
  return grant;
}

Result<void> Check(const Authority::Request& request) {
  const bool is_device = request.kind == Kind::kDevice;
  const auto is_safe = [](const std::string& text) {
    return !text.empty() && text.size() <= kMaxNameBytes &&
           text.find_first_not_of(
               "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") ==
               std::string::npos;
  };
  if (!is_safe(request.name) || (is_device && !is_safe(request.room))) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "name and room: expected 1 to {} of A-Z a-z 0-9 _ -, found \"{}\" and \"{}\"",
                     kMaxNameBytes, request.name, request.room);
  }
  if (is_device && FindUuid(request.name) == std::nullopt) {
    return MakeError(ErrorCode::kInvalidArgument, "device: expected a UUID, found \"{}\"",
                     request.name);
  }
  if (request.validity.until > request.validity.from) return {};
  return MakeError(ErrorCode::kInvalidArgument, "{}: would end before it begins", request.name);
}

}  // namespace

Result<fs::path> Authority::Issue(const Request& request) const {
  WAYMARK_TRY(Check(request));
  const fs::path out = request.out.empty() ? folder_ / "issued" / request.name : request.out;
  const bool is_there = fs::exists(out / "key.pem");
  if (is_there && !request.is_renewal) {
    return MakeError(ErrorCode::kConflict, "{}: holds credentials already", out.string());
  }
  if (!is_there && request.is_renewal) {
    return MakeError(ErrorCode::kNotFound, "{}: holds no credentials to renew", out.string());
  }
  WAYMARK_TRY_ASSIGN(const Credentials credentials,
                     identity_.Issue(request.name, request.validity));
  WAYMARK_TRY_ASSIGN(
      const std::string permissions,
      permissions_.SignDocument(PermissionsXml(MakeGrant(request, credentials.subject))));
  WAYMARK_TRY(CreateFolders(out));
  std::error_code failure;
  fs::permissions(out, fs::perms::owner_all, failure);  // it holds a key
  if (failure) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot be closed to others: {}", out.string(),
                     failure.message());
  }
  const auto store = [&](const char* name, const std::string& text) {
    return StoreFileAtomically(out / name, std::string_view(text));
  };
  WAYMARK_TRY(store("identity_ca.pem", identity_.CertificatePem()));
  WAYMARK_TRY(store("permissions_ca.pem", permissions_.CertificatePem()));
  WAYMARK_TRY_ASSIGN(const std::string governance, LoadTextFile(folder_ / "governance.p7s"));
  WAYMARK_TRY(store("governance.p7s", governance));
  WAYMARK_TRY(store("permissions.p7s", permissions));
  WAYMARK_TRY(store("certificate.pem", credentials.certificate_pem));
  if (request.kind != Kind::kDevice) WAYMARK_TRY(ShareTokenKeys(out));
  WAYMARK_TRY(store("key.pem", credentials.key_pem));
  return out;
}

Result<void> Authority::ShareTokenKeys(const fs::path& folder) const {
  WAYMARK_TRY(CreateFolders(folder / kTokenKeysFolder));
  WAYMARK_TRY_ASSIGN(const auto names, ListFolder(folder_ / kTokenKeysFolder));
  for (const std::string& name : names) {
    WAYMARK_TRY_ASSIGN(const std::string pem, LoadTextFile(folder_ / kTokenKeysFolder / name));
    WAYMARK_TRY(StoreFileAtomically(folder / kTokenKeysFolder / name, std::string_view(pem)));
  }
  const Result<std::string> revoked = LoadTextFile(folder_ / kRevocationsFile);
  if (!revoked) return {};  // nothing is
  return StoreFileAtomically(folder / kRevocationsFile, std::string_view(*revoked));
}

Result<void> Authority::ShareWithIssued() const {
  WAYMARK_TRY_ASSIGN(const auto names, ListFolder(folder_ / "issued"));
  for (const std::string& name : names) {
    const fs::path folder = folder_ / "issued" / name;
    if (fs::exists(folder / kTokenKeysFolder)) WAYMARK_TRY(ShareTokenKeys(folder));
  }
  return {};
}

Result<void> Authority::Revoke(std::string_view what, std::string_view id) const {
  WAYMARK_TRY(AddRevocation(folder_ / kRevocationsFile, what, id));
  return ShareWithIssued();
}

}  // namespace waymark::session::keys
