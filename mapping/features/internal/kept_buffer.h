// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "mapping/base/result.h"

namespace waymark::mapping::internal {

/// A large buffer that the process keeps for the next image when it is given back: fetched anew
/// from the kernel, its pages would be cleared again for each. What is kept never exceeds what was
/// once in use, and is marked so that the kernel takes it back when memory is short.
/// Its contents are unspecified but for this: whoever writes only finite floats reads only such.
class KeptBuffer {
 public:
  /// Errors: Unavailable when memory is short. Thread-safe.
  static Result<KeptBuffer> Take(std::size_t bytes);

  KeptBuffer() = default;
  KeptBuffer(KeptBuffer&& other) noexcept;
  KeptBuffer& operator=(KeptBuffer&& other) noexcept;
  ~KeptBuffer();

  /// Aligned to a page; `bytes` or more.
  void* data() const { return data_; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace waymark::mapping::internal
