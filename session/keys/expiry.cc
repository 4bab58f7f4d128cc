// SPDX-License-Identifier: Apache-2.0
#include "session/keys/expiry.h"

#include <fmt/chrono.h>

#include <algorithm>

#include "mapping/base/file.h"
#include "session/keys/dds_documents.h"

namespace waymark::session::keys {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::days kTwoWeeks{14};

Result<void> AddCertificate(const fs::path& file, std::vector<Ending>& endings) {
  if (!fs::exists(file)) return {};
  WAYMARK_TRY_ASSIGN(const std::string pem, LoadTextFile(file));
  CertificateFacts facts = ReadCertificate(pem);
  if (facts.name.empty()) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected a certificate in PEM", file.string());
  }
  endings.push_back({file, std::move(facts.name), facts.until});
  return {};
}

Result<void> AddPermissions(const fs::path& file, std::vector<Ending>& endings) {
  if (!fs::exists(file)) return {};
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(file));
  if (const auto until = FindPermissionsEnd(text)) endings.push_back({file, "permissions", *until});
  return {};
}

/// What its own files say, not those of folders in it.
Result<std::vector<Ending>> ListOwnEndings(const fs::path& folder) {
  std::vector<Ending> endings;
  if (folder.empty()) return endings;
  WAYMARK_TRY(AddCertificate(folder / "certificate.pem", endings));
  WAYMARK_TRY(AddCertificate(folder / "identity_ca.pem", endings));
  WAYMARK_TRY(AddPermissions(folder / "permissions.p7s", endings));
  WAYMARK_TRY(AddCertificate(folder / "permissions_ca.pem", endings));
  return endings;
}

/// Where the keys of an issued folder were made, as far as that can be seen from here.
std::string AuthorityOf(const fs::path& folder) {
  const fs::path parent = fs::absolute(folder).lexically_normal().parent_path();
  const bool is_here = parent.filename() == "issued" && fs::exists(parent.parent_path() / "secret");
  return is_here ? parent.parent_path().string() : "KEYS";
}

}  // namespace

Result<std::vector<Ending>> ListEndings(const fs::path& folder) {
  WAYMARK_TRY_ASSIGN(auto endings, ListOwnEndings(folder));
  WAYMARK_TRY_ASSIGN(const auto names, ListFolder(folder / "issued"));
  for (const std::string& name : names) {
    WAYMARK_TRY_ASSIGN(const auto issued, ListOwnEndings(folder / "issued" / name));
    endings.insert(endings.end(), issued.begin(), issued.end());
  }
  return endings;
}

std::string ExpiryWatch::Describe(const Ending& ending, WallTime now) const {
  const auto left = std::chrono::floor<std::chrono::days>(ending.until - now);
  const std::string file = ending.file.filename().string();
  const std::string when = fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", ending.until);
  const std::string said = ending.until > now
                               ? fmt::format("ends at {}, in {} days", when, left.count())
                               : fmt::format("has ended at {}", when);
  if (file.ends_with("_ca.pem")) {
    return fmt::format("{}: {}; `waymark-keys init` makes new keys, for all", ending.file.string(),
                       said);
  }
  std::string name = "NAME";
  if (const auto pem = LoadTextFile(folder_ / "certificate.pem")) {
    name = ReadCertificate(*pem).name;
  }
  const std::string keys = AuthorityOf(folder_);
  return fmt::format(
      "{}: {}; `waymark-keys issue {} {} {} --renew` makes another, {}taken up at the next start",
      ending.file.string(), said, keys, kind_, name,
      keys == "KEYS" ? "where its keys were made, to be copied here and " : "");
}

Result<void> ExpiryWatch::CheckNow(WallTime now) const {
  WAYMARK_TRY_ASSIGN(const auto endings, ListOwnEndings(folder_));
  for (const Ending& ending : endings) {
    if (ending.until > now) continue;
    return MakeError(ErrorCode::kInvalidArgument, "{}", Describe(ending, now));
  }
  return {};
}

std::optional<std::string> ExpiryWatch::TakeWarning(WallTime now) {
  const bool is_said = warned_ && now >= *warned_ && now - *warned_ < std::chrono::days(1);
  if (is_said) return std::nullopt;
  const auto endings = ListOwnEndings(folder_);
  if (!endings) {
    warned_ = now;
    return ToString(endings.error());
  }
  const auto first = std::ranges::min_element(*endings, {}, &Ending::until);
  if (first == endings->end() || first->until - now >= kTwoWeeks) return std::nullopt;
  warned_ = now;
  return Describe(*first, now);
}

}  // namespace waymark::session::keys
