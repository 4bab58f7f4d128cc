// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <istream>
#include <string>

#include "content_store/anchor_store.h"

namespace waymark::content {

/// A room as an RFC 7946 FeatureCollection: one point per anchor (longitude, latitude in degrees,
/// ellipsoid height), everything else in its properties. Quaternions are x, y, z, w. A payload that
/// is not text is in "payload_base64" instead of "payload". Pure.
std::string EncodeGeoJson(const RoomSnapshot& snapshot);

/// One anchor as a GeoJSON Feature.
std::string EncodeGeoJson(const AnchorRecord& record);
/// The same on one line.
std::string EncodeGeoJsonLine(const AnchorRecord& record);

/// Reads what EncodeGeoJson wrote, a FeatureCollection of any length, and hands over its anchors
/// one by one; no more than one is held. `take` may end the reading with an error. Numbers come
/// back to the last bit but one. Errors: InvalidArgument naming the feature and the field, and what
/// `take` returned.
Result<void> DecodeGeoJson(std::istream& in, const std::function<Result<void>(AnchorRecord)>& take);

}  // namespace waymark::content
