// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/ray_scene.h"

#include <embree3/rtcore.h>

#include <limits>
#include <utility>
#include <vector>

namespace waymark::simulator {
namespace {

/// Holds Embree's reference-counted handles.
template <typename Handle, void (*release)(Handle)>
struct Releaser {
  using pointer = Handle;
  void operator()(Handle handle) const { release(handle); }
};
using Device = std::unique_ptr<RTCDevice, Releaser<RTCDevice, rtcReleaseDevice>>;
using Scene = std::unique_ptr<RTCScene, Releaser<RTCScene, rtcReleaseScene>>;

struct Plane {
  Eigen::Vector3d normal;
  double offset;  // normal . x
};

RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, float far) {
  const Eigen::Vector3f o = origin.cast<float>();
  const Eigen::Vector3f d = direction.cast<float>();
  RTCRay ray{};
  ray.org_x = o.x();
  ray.org_y = o.y();
  ray.org_z = o.z();
  ray.dir_x = d.x();
  ray.dir_y = d.y();
  ray.dir_z = d.z();
  ray.tfar = far;
  ray.mask = ~0U;
  return ray;
}

void FillBuffers(RTCGeometry geometry, std::span<const Quad> quads) {
  auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * quads.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), quads.size()));
  unsigned next = 0;
  for (const Quad& quad : quads) {
    const Eigen::Vector3d right = quad.top_left + quad.edge_right;
    const Eigen::Vector3d below = quad.top_left + quad.edge_down;
    const Eigen::Vector3d across = quad.is_triangle ? below : below + quad.edge_right;
    for (const Eigen::Vector3d& corner : {quad.top_left, right, across, below}) {
      for (int axis = 0; axis < 3; ++axis) *corners++ = static_cast<float>(corner[axis]);
      *indices++ = next++;
    }
  }
}

}  // namespace

struct RayScene::Impl {
  Device device;
  Scene scene;
  std::vector<Plane> planes;
};

RayScene::RayScene(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;
RayScene::~RayScene() = default;

Result<RayScene> RayScene::Create(std::span<const Quad> quads) {
  auto impl = std::make_unique<Impl>();
  impl->device.reset(rtcNewDevice("threads=1,set_affinity=0"));
  if (!impl->device) {
    return MakeError(ErrorCode::kUnavailable, "ray scene: Embree has no device, error {}",
                     static_cast<int>(rtcGetDeviceError(nullptr)));
  }
  impl->scene.reset(rtcNewScene(impl->device.get()));
  rtcSetSceneFlags(impl->scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(impl->device.get(), RTC_GEOMETRY_TYPE_QUAD);
  FillBuffers(geometry, quads);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl->scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl->scene.get());
  const RTCError error = rtcGetDeviceError(impl->device.get());
  if (error != RTC_ERROR_NONE) {
    return MakeError(ErrorCode::kUnavailable, "ray scene of {} quads: Embree reports error {}",
                     quads.size(), static_cast<int>(error));
  }
  impl->planes.reserve(quads.size());
  for (const Quad& quad : quads) {
    const Eigen::Vector3d normal = quad.edge_down.cross(quad.edge_right);
    impl->planes.push_back({normal, normal.dot(quad.top_left)});
  }
  return RayScene(std::move(impl));
}

std::optional<Hit> RayScene::FindFirstHit(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray = MakeRay(origin, direction, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  // Embree computes in float; the plane gives the distance back in full.
  const Plane& plane = impl_->planes[query.hit.primID];
  const double distance = (plane.offset - plane.normal.dot(origin)) / plane.normal.dot(direction);
  return Hit{distance, query.hit.primID};
}

bool RayScene::IsBlocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         double distance_m) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = MakeRay(origin, direction, static_cast<float>(distance_m));
  rtcOccluded1(impl_->scene.get(), &context, &ray);
  return ray.tfar < 0;
}

}  // namespace waymark::simulator
