// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/frames.h"

#include <gmock/gmock.h>

#include "tests/support/random_geometry.h"

namespace waymark {
namespace {

template <typename A, typename B>
concept Chains = requires(const A& a, const B& b) {
  a* b;
};

// The point of the frame types: these are decided by the compiler.
static_assert(Chains<Transform<Map, Vo>, Transform<Vo, Device>>);
static_assert(!Chains<Transform<Map, Vo>, Transform<Device, Vo>>);
static_assert(!Chains<Transform<Vo, Device>, Transform<Map, Vo>>);
static_assert(Chains<Transform<Map, Vo>, Point<Vo>>);
static_assert(!Chains<Transform<Map, Vo>, Point<Map>>);
static_assert(!Chains<Similarity<Map, Submap>, Point<Map>>);
static_assert(!std::is_convertible_v<Transform<Map, Vo>, Transform<Vo, Map>>);

TEST(Transform, ChainsLikeItsRigidMotion) {
  support::RandomGeometry random(1);
  const Transform<Map, Vo> map_from_vo(random.Rigid());
  const Transform<Vo, Device> vo_from_device(random.Rigid());
  EXPECT_THAT((map_from_vo * vo_from_device).rigid(),
              support::Near(map_from_vo.rigid() * vo_from_device.rigid()));
  EXPECT_THAT((map_from_vo.Inverse() * map_from_vo).rigid(), support::Near(Rigid3()));
}

}  // namespace
}  // namespace waymark
