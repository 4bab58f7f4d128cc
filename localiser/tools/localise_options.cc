// SPDX-License-Identifier: Apache-2.0
#include "localiser/tools/localise_options.h"

namespace waymark::localiser {

void AddLocaliseOptions(CLI::App& app, LocaliseArguments& arguments) {
  app.footer(
      "Examples:\n"
      "  waymark-localise MAP DRIVE --out poses.csv                 a kapture folder, with its "
      "GNSS\n"
      "  waymark-localise MAP PHOTOS --out poses.csv --camera PINHOLE,640,480,520,520,320,240\n"
      "  waymark-localise MAP 1.jpg 2.jpg 3.jpg --odometry odom.tum --out pose.csv     a burst\n"
      "A burst is 2 to 16 images, oldest first, asked as one; the answer is where the last was "
      "taken.\n"
      "Odometry is TUM's: a line \"name tx ty tz qx qy qz qw\" for each image, "
      "odometry_from_camera in\n"
      "metres, camera axes x right, y down, z forward; the name is the file's, or its number.\n"
      "Poses are map_from_camera: metres, quaternion x, y, z, w. The file appears when all is "
      "done.\n"
      "Exit status: 0 done (refused images have their status in the table), 1 failed.");
  app.add_option("MAP", arguments.map, "a map directory with a release")->required();
  app.add_option("QUERY", arguments.queries, "a kapture folder, a folder of images, or a burst")
      ->required();
  app.add_option("--out", arguments.out, "the table of poses, CSV")->required();
  app.add_option("--odometry", arguments.odometry, "poses of a burst's images; QUERY is the burst");
  app.add_option("--odometry-up", arguments.odometry_up, "the direction that is up in odometry")
      ->expected(3)
      ->delimiter(',')
      ->default_str("0,0,1");
  app.add_option("--camera", arguments.camera,
                 "KIND,width,height,parameters; without it kapture's, or a guess from the size");
  app.add_option("--images", arguments.list, "a text file that names the images to localise");
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_option("--memory-mb", arguments.memory_mb,
                 "budget of submaps in memory, in 10^6 bytes; 0: all of them")
      ->check(CLI::Range(0.0, 1e9));
  app.add_option("--search", arguments.search,
                 "how landmarks are looked for: lists, or FLANN's kd-trees to compare with")
      ->transform(CLI::CheckedTransformer(std::map<std::string, SearchMethod>{
          {"lists", SearchMethod::kInvertedLists}, {"kd-trees", SearchMethod::kKdTrees}}));
  app.add_flag("--no-prior", arguments.no_prior, "search the whole map, whatever GNSS says");
  app.add_flag("--verbose", arguments.verbose, "say of each refused image why");
}

}  // namespace waymark::localiser
