// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/house_front.h"

#include <cmath>

namespace waymark::simulator {
namespace {

const Eigen::Vector3d kUp(0, 0, 1);

/// Cuts pieces out of a front, with the matching piece of its picture.
class FrontBuilder {
 public:
  FrontBuilder(const House& house, std::uint32_t facade, Mesh& mesh)
      : house_(house), facade_(facade), mesh_(mesh), wall_(mesh.NewSurface()) {}

  void AddWall(double left_m, double bottom_m, double right_m, double top_m) {
    if (right_m - left_m < 1e-6 || top_m - bottom_m < 1e-6) return;
    mesh_.Add({At(left_m, top_m, 0), (right_m - left_m) * house_.right, (bottom_m - top_m) * kUp,
               Piece(left_m, bottom_m, right_m, top_m), wall_, false});
  }

  /// The pane, set back, and the four cheeks between it and the wall.
  void AddOpening(const Opening& opening, double sill_m, double head_m, double depth_m) {
    const double left = opening.left_m;
    const double right = opening.right_m;
    const Eigen::Vector3d across = (right - left) * house_.right;
    const Eigen::Vector3d down = (sill_m - head_m) * kUp;
    const Eigen::Vector3d in = -depth_m * house_.toward;
    mesh_.AddQuad(At(left, head_m, depth_m), across, down, Piece(left, sill_m, right, head_m));
    // Cheeks show the surround that the painter put beside the opening.
    mesh_.AddQuad(At(left, head_m, 0), in, down, Piece(left - 0.09, sill_m, left - 0.01, head_m));
    mesh_.AddQuad(At(right, head_m, depth_m), -in, down,
                  Piece(right + 0.01, sill_m, right + 0.09, head_m));
    mesh_.AddQuad(At(left, sill_m, depth_m), across, -in,
                  Piece(left, sill_m - 0.1, right, sill_m - 0.02));
    mesh_.AddQuad(At(left, head_m, 0), across, in, Piece(left, head_m + 0.02, right, head_m + 0.1));
  }

 private:
  Eigen::Vector3d At(double along_m, double height_m, double depth_m) const {
    return house_.foot + along_m * house_.right + height_m * kUp - depth_m * house_.toward;
  }
  Material Piece(double left_m, double bottom_m, double right_m, double top_m) const {
    const FacadePlan& plan = house_.plan;
    return {facade_,
            {left_m / plan.width_m, 1 - top_m / plan.height_m, right_m / plan.width_m,
             1 - bottom_m / plan.height_m}};
  }

  const House& house_;
  std::uint32_t facade_;
  Mesh& mesh_;
  std::uint32_t wall_;
};

/// A box flat against the front: `at_m` from the left, `bottom_m` up, reaching out by size.y().
Box OnFront(const House& house, double at_m, double bottom_m, const Eigen::Vector3d& size) {
  return {house.foot + at_m * house.right + bottom_m * kUp + size.y() / 2 * house.toward, size,
          std::atan2(house.right.y(), house.right.x())};
}

}  // namespace

void BuildFront(const House& house, std::uint32_t facade, Mesh& mesh) {
  const FacadePlan& plan = house.plan;
  FrontBuilder builder(house, facade, mesh);
  for (const Storey& storey : plan.storeys) {
    builder.AddWall(0, storey.floor_m, plan.width_m, storey.sill_m);
    builder.AddWall(0, storey.head_m, plan.width_m, storey.ceiling_m);
    double done = 0;
    for (const Opening& opening : storey.openings) {
      builder.AddWall(done, storey.sill_m, opening.left_m, storey.head_m);
      builder.AddOpening(opening, storey.sill_m, storey.head_m, opening.is_door ? 0.3 : 0.16);
      done = opening.right_m;
    }
    builder.AddWall(done, storey.sill_m, plan.width_m, storey.head_m);
  }
  builder.AddWall(0, plan.storeys.back().ceiling_m, plan.width_m, plan.height_m);
}

void AddOrnaments(const House& house, const SharedMaterials& shared, Random& random, Mesh& mesh) {
  const FacadePlan& plan = house.plan;
  const auto any = [&] { return shared.boards[random.Bits() % shared.boards.size()]; };
  const auto any_sign = [&] { return shared.signs[random.Bits() % shared.signs.size()]; };
  const double width = plan.width_m;
  mesh.AddBox(OnFront(house, width / 2, plan.height_m - 0.35, {width, 0.3, 0.3}), any());
  if (random.Chance(0.7)) {  // a rain pipe
    mesh.AddBox(OnFront(house, 0.12, 0, {0.1, 0.12, plan.height_m - 0.4}), any());
  }
  const Storey& ground = plan.storeys.front();
  if (plan.has_shop && random.Chance(0.5)) {
    const Opening& shaded = ground.openings[random.Bits() % ground.openings.size()];
    const Eigen::Vector3d top =
        house.foot + (shaded.left_m - 0.15) * house.right + (ground.head_m + 0.25) * kUp;
    mesh.AddQuad(top, (shaded.right_m - shaded.left_m + 0.3) * house.right,
                 1.1 * house.toward - 0.55 * kUp, any());
  }
  for (int i = random.Integer(0, 2); i > 0; --i) {  // signs that hang out over the pavement
    mesh.AddBox(OnFront(house, random.Uniform(0.5, width - 0.5), random.Uniform(2.6, 3.6),
                        {0.12, random.Uniform(0.6, 1), random.Uniform(0.5, 1)}),
                any_sign());
  }
  for (std::size_t i = 1; i < plan.storeys.size(); ++i) {
    const Storey& storey = plan.storeys[i];
    for (const Opening& opening : storey.openings) {
      const double centre = (opening.left_m + opening.right_m) / 2;
      const double breadth = opening.right_m - opening.left_m;
      if (plan.has_balconies && random.Chance(0.35)) {
        mesh.AddBox(OnFront(house, centre, storey.floor_m, {breadth + 0.6, 0.9, 0.95}), any());
      } else if (random.Chance(0.2)) {  // a flower box
        mesh.AddBox(OnFront(house, centre, storey.sill_m - 0.2, {breadth, 0.25, 0.25}), any());
      } else if (random.Chance(0.07)) {  // an air conditioner
        mesh.AddBox(OnFront(house, opening.right_m, storey.floor_m + 0.1, {0.8, 0.4, 0.6}), any());
      }
    }
  }
}

}  // namespace waymark::simulator
