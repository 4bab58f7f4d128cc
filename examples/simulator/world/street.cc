// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/street.h"

#include <cmath>
#include <optional>

namespace waymark::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Places along a segment: metres along it, metres to its left, height.
class SegmentFrame {
 public:
  explicit SegmentFrame(const StreetSegment& segment) : segment_(segment) {}

  Vector3d along() const { return {segment_.direction.x(), segment_.direction.y(), 0}; }
  Vector3d left() const { return {-segment_.direction.y(), segment_.direction.x(), 0}; }
  double yaw_rad() const { return std::atan2(segment_.direction.y(), segment_.direction.x()); }
  Vector3d At(double along_m, double left_m, double height_m) const {
    return Vector3d(segment_.start.x(), segment_.start.y(), height_m) + along_m * along() +
           left_m * left();
  }

 private:
  const StreetSegment& segment_;
};

void PlanBuildingLines(const Vector2d& low, const Vector2d& high, StreetPlan& plan) {
  for (const Block& block : plan.blocks) {
    const Vector2d size = block.high - block.low;
    plan.building_lines.push_back({block.low, {1, 0}, size.x()});
    plan.building_lines.push_back({{block.high.x(), block.low.y()}, {0, 1}, size.y()});
    plan.building_lines.push_back({block.high, {-1, 0}, size.x()});
    plan.building_lines.push_back({{block.low.x(), block.high.y()}, {0, -1}, size.y()});
  }
  const Vector2d size = high - low;  // the ring looks inwards, so it runs the other way round
  plan.building_lines.push_back({{high.x(), low.y()}, {-1, 0}, size.x()});
  plan.building_lines.push_back({high, {0, -1}, size.y()});
  plan.building_lines.push_back({{low.x(), high.y()}, {1, 0}, size.x()});
  plan.building_lines.push_back({low, {0, 1}, size.y()});
}

/// Where it shines from, if it is a lamp.
constexpr double kLampHeight = 5.2;  // metres

std::optional<Vector3d> BuildPost(const Vector3d& place, const SharedMaterials& shared,
                                  Random& random, Mesh& mesh) {
  const auto board = [&] { return shared.boards[random.Bits() % shared.boards.size()]; };
  const auto sign = [&] { return shared.signs[random.Bits() % shared.signs.size()]; };
  switch (random.Integer(0, 5)) {
    case 0:  // a street lamp
      mesh.AddColumn(place, 0.08, kLampHeight, 8, board());
      mesh.AddBox({place + Vector3d(0, 0, kLampHeight), {0.5, 0.3, 0.15}, 0}, board());
      return place + Vector3d(0, 0, kLampHeight);
    case 1:  // a traffic sign
      mesh.AddColumn(place, 0.035, 2.9, 6, board());
      mesh.AddBox({place + Vector3d(0, 0, 2.2), {0.04, 0.6, 0.6}, random.Uniform(0, 3.1)}, sign());
      return std::nullopt;
    case 2:  // a litter bin
      mesh.AddColumn(place, 0.24, 0.9, 10, board());
      return std::nullopt;
    case 3:  // a cabinet
      mesh.AddBox({place, {0.9, 0.4, 1.2}, random.Chance(0.5) ? 0 : 1.5708}, sign());
      return std::nullopt;
    case 4:  // a planter
      mesh.AddBox({place, {0.8, 0.6, 0.55}, 0}, board());
      mesh.AddColumn(place + Vector3d(0, 0, 0.5), 0.25, random.Uniform(0.3, 0.9), 7, board());
      return std::nullopt;
    default:  // an advertising column
      mesh.AddColumn(place, 0.33, 1.5, 12, sign());
      return std::nullopt;
  }
}

}  // namespace

StreetPlan PlanStreets(const CityOptions& options) {
  StreetPlan plan;
  const double width = options.StreetWidth();
  const Vector2d block(options.block_east_m, options.block_north_m);
  const Vector2d pitch = block + Vector2d(width, width);
  const Vector2d half(width / 2, width / 2);
  for (int north = 0; north <= options.blocks_north; ++north) {
    for (int east = 0; east <= options.blocks_east; ++east) {
      const Vector2d low(east * pitch.x(), north * pitch.y());
      plan.crossings.push_back(low - half);
      if (east < options.blocks_east) {
        plan.segments.push_back({low - Vector2d(0, width / 2), {1, 0}, block.x()});
      }
      if (north < options.blocks_north) {
        plan.segments.push_back({low - Vector2d(width / 2, 0), {0, 1}, block.y()});
      }
      if (east < options.blocks_east && north < options.blocks_north) {
        plan.blocks.push_back({low, low + block});
      }
    }
  }
  const Vector2d outer_low(-width, -width);
  const Vector2d outer_high(options.blocks_east * pitch.x(), options.blocks_north * pitch.y());
  PlanBuildingLines(outer_low, outer_high, plan);
  return plan;
}

void BuildStreet(const StreetSegment& segment, const CityOptions& options, std::uint32_t street,
                 Mesh& mesh) {
  const SegmentFrame frame(segment);
  const double half_road = options.road_m / 2;
  const double half = options.StreetWidth() / 2;
  const double edge = options.pavement_m / options.StreetWidth();  // of the kerb, in v
  const Vector3d along = segment.length_m * frame.along();
  const Vector3d right = -frame.left();
  mesh.AddQuad(frame.At(0, half_road, 0), along, options.road_m * right,
               {street, {0, edge, 1, 1 - edge}});
  mesh.AddQuad(frame.At(0, half, kKerbHeight), along, options.pavement_m * right,
               {street, {0, 0, 1, edge}});
  mesh.AddQuad(frame.At(0, -half_road, kKerbHeight), along, options.pavement_m * right,
               {street, {0, 1 - edge, 1, 1}});
  const double stone = 0.14 / options.StreetWidth();  // the painted kerb stones
  const Vector3d down(0, 0, -kKerbHeight);
  mesh.AddQuad(frame.At(0, half_road, kKerbHeight), along, down,
               {street, {0, edge - stone, 1, edge}});
  mesh.AddQuad(frame.At(0, -half_road, kKerbHeight), along, down,
               {street, {0, 1 - edge, 1, 1 - edge + stone}});
}

void BuildCrossing(const Eigen::Vector2d& centre, const CityOptions& options,
                   std::uint32_t crossing, Mesh& mesh) {
  const double width = options.StreetWidth();
  const double corner = options.pavement_m;
  const Vector3d top_left(centre.x() - width / 2, centre.y() + width / 2, 0);
  mesh.AddQuad(top_left, {width, 0, 0}, {0, -width, 0}, {crossing, {}});
  const double share = corner / width;
  for (const double u : {0.0, 1 - share}) {
    for (const double v : {0.0, 1 - share}) {
      mesh.AddQuad(top_left + Vector3d(u * width, -v * width, kKerbHeight), {corner, 0, 0},
                   {0, -corner, 0}, {crossing, {u, v, u + share, v + share}});
    }
  }
}

std::vector<Vector3d> BuildFurniture(const StreetSegment& segment, const CityOptions& options,
                                     const SharedMaterials& shared, Random random, Mesh& mesh) {
  const SegmentFrame frame(segment);
  const double offset = options.road_m / 2 + 0.45;
  std::vector<Vector3d> lamps;
  for (const double side : {1.0, -1.0}) {
    double along = random.Uniform(1.5, 5);
    while (along < segment.length_m - 1) {
      const auto lamp =
          BuildPost(frame.At(along, side * offset, kKerbHeight), shared, random, mesh);
      if (lamp) lamps.push_back(*lamp);
      along += random.Uniform(4, 9);
    }
  }
  return lamps;
}

}  // namespace waymark::simulator
