// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::mapping::internal {

/// Fits OpenCV to a program that spreads images over threads itself; called before OpenCV is used,
/// cheap after the first time, thread-safe.
///
/// - OpenCV works on its caller's thread: a second pool under ours would only contend.
/// - Large pixel buffers are kept for the next image. A scale space of a 6-megapixel photo takes
///   1.5 GB; fetched anew from the kernel for each image, clearing those pages took 0.4 to 1 s of
///   2 s. What is kept never exceeds what was once in use, and is marked so that the kernel takes
///   it back when memory is short.
void SetUpOpenCv();

}  // namespace waymark::mapping::internal
