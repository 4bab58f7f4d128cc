// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/house.h"

#include <algorithm>

#include "examples/simulator/world/house_front.h"

namespace waymark::simulator {
namespace {

constexpr double kDepth = 9;       // of a house, front to back
constexpr double kTilePeriod = 4;  // metres per repetition of the shared textures
const Eigen::Vector3d kUp(0, 0, 1);

Material Tiled(std::uint32_t texture, double width_m, double height_m) {
  return {texture, {0, 0, width_m / kTilePeriod, height_m / kTilePeriod}};
}

void BuildFlatRoof(const House& house, const SharedMaterials& shared, Mesh& mesh) {
  const Eigen::Vector3d back = -kDepth * house.toward;
  const Eigen::Vector3d top = house.foot + house.plan.height_m * kUp;
  mesh.AddQuad(top + back, house.plan.width_m * house.right, -back,
               Tiled(shared.roof, house.plan.width_m, kDepth));
}

void BuildPitchedRoof(const House& house, const SharedMaterials& shared, double rise_m,
                      Mesh& mesh) {
  const Eigen::Vector3d width = house.plan.width_m * house.right;
  const Eigen::Vector3d eave = house.foot + house.plan.height_m * kUp;
  const Eigen::Vector3d to_ridge = -kDepth / 2 * house.toward + rise_m * kUp;
  const Eigen::Vector3d ridge = eave + to_ridge;
  const Material tiles = Tiled(shared.roof, house.plan.width_m, to_ridge.norm());
  mesh.AddQuad(ridge, width, -to_ridge, tiles);
  const Eigen::Vector3d to_back = -kDepth / 2 * house.toward - rise_m * kUp;
  mesh.AddQuad(ridge + width, -width, to_back, tiles);
  const Material gable = Tiled(shared.side_wall, kDepth, rise_m);
  for (const Eigen::Vector3d& end : {Eigen::Vector3d(ridge), Eigen::Vector3d(ridge + width)}) {
    mesh.Add({end, to_back, -to_ridge, gable, mesh.NewSurface(), true});
  }
}

void BuildChimney(const House& house, const SharedMaterials& shared, Random& random, Mesh& mesh) {
  const double along = random.Uniform(0.1, 0.9) * house.plan.width_m;
  const Eigen::Vector3d base =
      house.foot + along * house.right - kDepth / 3 * house.toward + house.plan.height_m * kUp;
  mesh.AddBox({base, {0.7, 0.7, random.Uniform(2, 3.4)}, 0}, Tiled(shared.side_wall, 0.7, 3));
}

}  // namespace

std::vector<House> PlanRow(const BuildingLine& line, Random random, int kinds, Random pattern) {
  std::vector<House> houses;
  const Eigen::Vector3d right(line.direction.x(), line.direction.y(), 0);
  const Eigen::Vector3d toward = right.cross(kUp);  // right x up points to the viewer
  double done = 0;
  while (done < line.length_m - 1e-6) {
    const double rest = line.length_m - done;
    if (kinds > 0) random = pattern.Fork(houses.size() % static_cast<std::size_t>(kinds));
    double width = random.Uniform(7, 12.5);
    if (rest - width < 6) width = rest < 13 ? rest : rest / 2;
    const double height = random.Uniform(8.5, 15.5);
    const double projection = random.Uniform(0.4, 0.8);  // recesses stay before the corner
    const Eigen::Vector3d foot =
        Eigen::Vector3d(line.start.x(), line.start.y(), 0) + done * right + projection * toward;
    const std::uint64_t seed = random.Bits();
    houses.push_back({foot, right, toward, PlanFacade(width, height, Random(seed)), seed});
    done += width;
  }
  return houses;
}

void BuildHouse(const House& house, std::uint32_t facade, const SharedMaterials& shared,
                Mesh& mesh) {
  Random random = Random(house.seed).Fork(1);
  BuildFront(house, facade, mesh);
  AddOrnaments(house, shared, random, mesh);
  const Eigen::Vector3d back = -kDepth * house.toward;
  const Eigen::Vector3d width = house.plan.width_m * house.right;
  const Eigen::Vector3d top = house.foot + house.plan.height_m * kUp;
  const Eigen::Vector3d down = -house.plan.height_m * kUp;
  const Material side = Tiled(shared.side_wall, kDepth, house.plan.height_m);
  mesh.AddQuad(top + back, -back, down, side);
  mesh.AddQuad(top + width, back, down, side);
  mesh.AddQuad(top + width + back, -width, down,
               Tiled(shared.side_wall, house.plan.width_m, house.plan.height_m));
  if (random.Chance(0.5)) {
    BuildFlatRoof(house, shared, mesh);
  } else {
    BuildPitchedRoof(house, shared, random.Uniform(1.8, 3.5), mesh);
  }
  if (random.Chance(0.6)) BuildChimney(house, shared, random, mesh);
}

}  // namespace waymark::simulator
