// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::mapping::internal {

/// Keeps OpenCV on its caller's thread: a second pool under ours would only contend. Called before
/// OpenCV is used, cheap after the first time, thread-safe.
void SetUpOpenCv();

}  // namespace waymark::mapping::internal
