// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <sstream>
#include <string>
#include <vector>

#include "mapping/io/export_submap.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::mapping {

/// A submap in which every observation is where its landmark projects.
inline SubmapModel ConsistentSubmap(std::uint64_t seed) {
  SubmapModel model = ExampleSubmap(seed, 40);
  support::RandomGeometry random(seed);
  for (SubmapImage& image : model.images) {
    image.submap_from_camera = Transform<Submap, Camera>(RotationFromVector(random.Vector(0.1)),
                                                         Eigen::Vector3d(random.Vector(1)));
  }
  for (auto& landmark : model.landmarks) {
    landmark = Point<Submap>(random.Vector(3) + Eigen::Vector3d(0, 0, 12));
  }
  for (LandmarkObservation& observation : model.observations) {
    const SubmapImage& image = model.images[observation.image];
    const auto x_in_camera =
        image.submap_from_camera.Inverse() * model.landmarks[observation.landmark];
    const auto pixel = model.cameras[image.camera].Project(x_in_camera.coordinates()).value();
    observation.x_px = static_cast<float>(pixel.x());
    observation.y_px = static_cast<float>(pixel.y());
  }
  return model;
}

/// The lines of a text file that are no comments.
inline std::vector<std::string> DataLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] != '#') lines.push_back(line);
  }
  return lines;
}

/// Two submaps that share an image.
class Export : public testing::Test {
 protected:
  Export() : first_(ConsistentSubmap(1)), second_(ConsistentSubmap(2)) {
    // Image 2 of the first is borrowed; the second owns it. Its own image 2 is elsewhere.
    second_.images[2].is_borrowed = false;
    second_.images[0].name = "front/7.jpg";
    second_.images[1].name = "front/8.jpg";
    support::RandomGeometry random(5);
    submaps_ = {ExportSubmap(first_, Similarity<Map, Submap>(random.Similarity())),
                ExportSubmap(second_, Similarity<Map, Submap>(random.Similarity()))};
  }

  SubmapModel first_;
  SubmapModel second_;
  std::vector<ExportSubmap> submaps_;
};

}  // namespace waymark::mapping
