// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waymark::session::keys {

/// The name of an owner of anchors, from the secret that its devices and nobody else know.
/// Everybody may learn the name and nobody can be the owner by it: it is no device's id, and does
/// not give the secret back if that is not to be guessed. Empty for an empty secret: the device
/// itself owns. Source: SHA-256, the first 128 bits: "@" and 32 hex digits.
std::string OwnerOf(std::string_view secret);

}  // namespace waymark::session::keys
