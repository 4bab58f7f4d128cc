// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "content_store/anchor_store.h"

namespace waymark::content {

/// A room as an RFC 7946 FeatureCollection: one point per anchor (longitude, latitude in degrees,
/// ellipsoid height), everything else in its properties. Quaternions are x, y, z, w. A payload that
/// is not text is in "payload_base64" instead of "payload". Pure.
std::string EncodeGeoJson(const RoomSnapshot& snapshot);

/// One anchor as a GeoJSON Feature.
std::string EncodeGeoJson(const AnchorRecord& record);

}  // namespace waymark::content
