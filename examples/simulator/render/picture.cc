// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/picture.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <fstream>

namespace waymark::simulator {

Result<void> StorePicture(const ColourImage& picture, const std::filesystem::path& path,
                          int jpeg_quality) {
  const std::string ending = path.extension().string();
  if (ending != ".png" && ending != ".jpg") {
    return MakeError(ErrorCode::kInvalidArgument, "picture {}: expected .png or .jpg, found \"{}\"",
                     path.string(), ending);
  }
  std::vector<unsigned char> bytes;
  try {
    cv::Mat bgr(picture.height_px, picture.width_px, CV_8UC3);
    const std::uint8_t* from = picture.values.data();
    for (auto* to = bgr.data; to != bgr.dataend; to += 3, from += 3) {
      to[0] = from[2];
      to[1] = from[1];
      to[2] = from[0];
    }
    const std::vector<int> options = ending == ".jpg"
                                         ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, jpeg_quality}
                                         : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 1};
    cv::imencode(ending, bgr, bytes, options);
  } catch (const cv::Exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "picture {}: encoding failed: {}", path.string(),
                     exception.what());
  }
  // Not fsynced: simulated pictures can be made again.
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    return MakeError(ErrorCode::kUnavailable, "picture {}: cannot be written", path.string());
  }
  return {};
}

}  // namespace waymark::simulator
