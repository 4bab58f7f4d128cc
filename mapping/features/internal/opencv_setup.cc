// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/opencv_setup.h"

#include <mutex>
#include <opencv2/core.hpp>

namespace waymark::mapping::internal {

void SetUpOpenCv() {
  static std::once_flag once;
  std::call_once(once, [] { cv::setNumThreads(1); });
}

}  // namespace waymark::mapping::internal
