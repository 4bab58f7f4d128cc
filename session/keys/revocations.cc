// SPDX-License-Identifier: Apache-2.0
#include "session/keys/revocations.h"

#include <fmt/format.h>

#include "mapping/base/file.h"
#include "session/state/uuid.h"

namespace waymark::session::keys {
namespace {

Result<void> AddLine(std::string_view line, int number, Revocations& revocations) {
  if (line.empty() || line.front() == '#') return {};
  const std::size_t space = line.find(' ');
  const std::string_view what = line.substr(0, space);
  const std::string id(space == std::string_view::npos ? "" : line.substr(space + 1));
  const auto uuid = FindUuid(id);
  if (what == "token" && !id.empty()) {
    revocations.tokens.insert(id);
  } else if (what == "key" && !id.empty()) {
    revocations.keys.insert(id);
  } else if (what == "gateway" && !id.empty()) {
    revocations.gateways.insert(id);
  } else if (what == "device" && uuid) {
    revocations.devices.insert(DeviceId(FormatUuid(*uuid)));
  } else {
    return MakeError(ErrorCode::kInvalidArgument,
                     "line {}: expected `token ID`, `device UUID`, `key ID` or `gateway NAME`",
                     number);
  }
  return {};
}

}  // namespace

std::set<std::string> Revocations::Names() const {
  std::set<std::string> names = gateways;
  for (const DeviceId& device : devices) names.insert(device.text());
  return names;
}

Result<Revocations> ParseRevocations(std::string_view text) {
  Revocations revocations;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    WAYMARK_TRY(AddLine(line, number, revocations));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return revocations;
}

Result<Revocations> LoadRevocations(const std::filesystem::path& path) {
  const Result<std::string> text = LoadTextFile(path);
  if (!text && text.error().code == ErrorCode::kNotFound) return Revocations{};
  if (!text) return text.error();
  Result<Revocations> revocations = ParseRevocations(*text);
  if (revocations) return revocations;
  return MakeError(revocations.error().code, "{}: {}", path.string(), revocations.error().message);
}

Result<void> AddRevocation(const std::filesystem::path& path, std::string_view what,
                           std::string_view id) {
  Result<std::string> text = LoadTextFile(path);
  if (!text && text.error().code != ErrorCode::kNotFound) return text.error();
  std::string lines = text ? *std::move(text) : "";
  if (!lines.empty() && !lines.ends_with('\n')) lines += '\n';
  lines += fmt::format("{} {}\n", what, id);
  WAYMARK_TRY(ParseRevocations(lines));
  return StoreFileAtomically(path, std::string_view(lines));
}

}  // namespace waymark::session::keys
