// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace waymark::session {

/// What a device may do in its room. A viewer sees and is seen to be there; a member also shares
/// its pose and writes anchors; a moderator also edits everybody's anchors, removes devices and
/// sets the room's capacity. The numbers are those of the wire.
enum class Role : std::uint8_t { kMember, kViewer, kModerator };

constexpr bool MaySharePose(Role role) { return role != Role::kViewer; }
constexpr bool MayWriteAnchors(Role role) { return role != Role::kViewer; }
constexpr bool MayModerate(Role role) { return role == Role::kModerator; }

/// "member", "viewer", "moderator", as users write it.
constexpr std::string_view RoleName(Role role) {
  return role == Role::kViewer ? "viewer" : role == Role::kModerator ? "moderator" : "member";
}

/// The inverse of RoleName.
constexpr std::optional<Role> FindRole(std::string_view name) {
  for (const Role role : {Role::kMember, Role::kViewer, Role::kModerator}) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

}  // namespace waymark::session
