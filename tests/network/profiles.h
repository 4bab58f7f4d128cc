// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "tests/network/link.h"

namespace waymark::network {

/// What a phone's network is like.
struct Profile {
  std::string_view name;
  std::string_view source;  ///< where the figures come from
  LinkOptions up;           ///< from the phone
  LinkOptions down;         ///< to the phone
};

/// "none", "4g", "3g", "crowded".
std::span<const Profile> Profiles();
/// Null when there is none of that name.
const Profile* FindProfile(std::string_view name);

}  // namespace waymark::network
