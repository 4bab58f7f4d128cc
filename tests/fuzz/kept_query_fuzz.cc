// SPDX-License-Identifier: Apache-2.0
// Questions of phones that were kept to be asked again.
#include <array>

#include "mapping/base/check.h"
#include "session/rehearsal/kept_query.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {
namespace {

session::LocaliseQuery ExampleQuery(bool is_bare) {
  const std::array parameters{300.25, 300.0, 160.0, 120.125};
  session::LocaliseQuery query{
      .ticket = {},
      .request = {},
      .time = {},
      .camera = *CameraModel::Create(CameraKind::kPinhole, 320, 240, parameters),
      .prior = {},
      .up_in_camera = {},
      .image = {1, 2, 3, 10, 4}};
  if (is_bare) return query;
  query.prior = session::GeoPrior{{Angle::Degrees(37.77), Angle::Degrees(-122.42), 12.5}, 8};
  query.up_in_camera = Eigen::Vector3d(0.6, -0.8, 0);
  return query;
}

}  // namespace

std::vector<Bytes> Seeds() {
  return {session::EncodeKeptQuery(ExampleQuery(false)),
          session::EncodeKeptQuery(ExampleQuery(true))};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  const auto query = session::DecodeKeptQuery(bytes, "fuzz");
  if (!query) return;
  CHECK(session::DecodeKeptQuery(session::EncodeKeptQuery(*query), "fuzz").ok(),
        "what was read cannot be kept");
}

}  // namespace waymark::fuzz
