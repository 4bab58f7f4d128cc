// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/kept_buffer.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

namespace waymark::mapping::internal {
namespace {

constexpr std::size_t kGranule = std::size_t{2} << 20;  ///< a huge page

struct Block {
  void* data = nullptr;
  std::size_t size = 0;
};

/// Buffers from the kernel, kept for reuse. Thread-safe.
class Pool {
 public:
  /// The smallest kept one that is large enough, or one from the kernel; no data: out of memory.
  Block Take(std::size_t bytes) {
    const std::size_t size = (bytes + kGranule - 1) / kGranule * kGranule;
    Block block = TakeKept(size);
    if (!block.data) {
      void* const fresh =
          mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
      if (fresh == MAP_FAILED) return {};
      madvise(fresh, size, MADV_HUGEPAGE);  // a wish: nothing is wrong if it is refused
      block = {fresh, size};
    }
    const std::lock_guard lock(mutex_);
    in_use_ += block.size;
    most_in_use_ = std::max(most_in_use_, in_use_);
    return block;
  }

  /// Keeps it, if need be in the place of smaller ones.
  void Return(Block block) {
    madvise(block.data, block.size, MADV_FREE);
    const std::lock_guard lock(mutex_);
    in_use_ -= block.size;
    kept_.emplace(block.size, block.data);
    kept_bytes_ += block.size;
    while (kept_bytes_ > most_in_use_) {
      const Block smallest = Remove(kept_.begin());
      munmap(smallest.data, smallest.size);
    }
  }

 private:
  /// When all are too small, the largest gives way: images have grown.
  Block TakeKept(std::size_t size) {
    const std::lock_guard lock(mutex_);
    if (kept_.empty()) return {};
    auto found = kept_.lower_bound(size);
    const bool fits = found != kept_.end();
    if (!fits) --found;
    const Block block = Remove(found);
    if (fits) return block;
    munmap(block.data, block.size);
    return {};
  }

  Block Remove(std::multimap<std::size_t, void*>::iterator kept) {
    const Block block{kept->second, kept->first};
    kept_.erase(kept);
    kept_bytes_ -= block.size;
    return block;
  }

  std::mutex mutex_;
  std::multimap<std::size_t, void*> kept_;  // guarded by mutex_, as is all below
  std::size_t kept_bytes_ = 0;
  std::size_t in_use_ = 0;
  std::size_t most_in_use_ = 0;
};

Pool& ThePool() {
  static Pool* const pool = new Pool;  // never destroyed: buffers of static objects may outlive it
  return *pool;
}

}  // namespace

Result<KeptBuffer> KeptBuffer::Take(std::size_t bytes) {
  const Block block = ThePool().Take(bytes);
  if (!block.data) {
    return MakeError(ErrorCode::kUnavailable, "a buffer of {} bytes: {}", bytes,
                     std::strerror(errno));
  }
  KeptBuffer buffer;
  buffer.data_ = block.data;
  buffer.size_ = block.size;
  return buffer;
}

KeptBuffer::KeptBuffer(KeptBuffer&& other) noexcept { *this = std::move(other); }

KeptBuffer& KeptBuffer::operator=(KeptBuffer&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

KeptBuffer::~KeptBuffer() {
  if (data_) ThePool().Return({data_, size_});
}

}  // namespace waymark::mapping::internal
