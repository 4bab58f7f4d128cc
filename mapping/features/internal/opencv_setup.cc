// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/opencv_setup.h"

#include <sys/mman.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>

namespace waymark::mapping::internal {
namespace {

constexpr std::size_t kSmallestKept = std::size_t{1} << 20;
constexpr std::size_t kGranule = std::size_t{2} << 20;  ///< a huge page

/// Buffers from the kernel, kept for reuse. Thread-safe.
class BufferPool {
 public:
  /// Throws cv::Exception as OpenCV's own allocator does when memory is short.
  void* Take(std::size_t size) {
    size = Rounded(size);
    if (void* const kept = TakeKept(size)) return kept;
    void* const fresh =
        mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (fresh == MAP_FAILED) CV_Error(cv::Error::StsNoMem, cv::format("%zu bytes refused", size));
    madvise(fresh, size, MADV_HUGEPAGE);  // a wish: nothing is wrong if it is refused
    const std::lock_guard lock(mutex_);
    in_use_ += size;
    most_in_use_ = std::max(most_in_use_, in_use_);
    return fresh;
  }

  void Return(void* buffer, std::size_t size) {
    size = Rounded(size);
    madvise(buffer, size, MADV_FREE);
    {
      const std::lock_guard lock(mutex_);
      in_use_ -= size;
      if (kept_bytes_ + size <= most_in_use_) {
        kept_.emplace(size, buffer);
        kept_bytes_ += size;
        return;
      }
    }
    munmap(buffer, size);
  }

 private:
  static std::size_t Rounded(std::size_t size) {
    return (size + kGranule - 1) / kGranule * kGranule;
  }

  void* TakeKept(std::size_t size) {
    const std::lock_guard lock(mutex_);
    const auto found = kept_.find(size);
    if (found == kept_.end()) return nullptr;
    void* const buffer = found->second;
    kept_.erase(found);
    kept_bytes_ -= size;
    in_use_ += size;
    most_in_use_ = std::max(most_in_use_, in_use_);
    return buffer;
  }

  std::mutex mutex_;
  std::multimap<std::size_t, void*> kept_;  // guarded by mutex_, as is all below
  std::size_t kept_bytes_ = 0;
  std::size_t in_use_ = 0;
  std::size_t most_in_use_ = 0;
};

/// Gives large matrices buffers of the pool and leaves the others to OpenCV.
class PooledAllocator final : public cv::MatAllocator {
 public:
  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, std::size_t* step,
                         cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    std::size_t total = CV_ELEM_SIZE(type);
    for (int i = 0; i < dims; ++i) total *= static_cast<std::size_t>(sizes[i]);
    if (data || total < kSmallestKept) {
      return cv::Mat::getStdAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
    }
    std::size_t stride = CV_ELEM_SIZE(type);
    for (int i = dims - 1; i >= 0; --i) {
      if (step) step[i] = stride;
      stride *= static_cast<std::size_t>(sizes[i]);
    }
    auto matrix = std::make_unique<cv::UMatData>(this);
    matrix->data = matrix->origdata = static_cast<uchar*>(pool_.Take(total));
    matrix->size = total;
    return matrix.release();
  }

  bool allocate(cv::UMatData* matrix, cv::AccessFlag, cv::UMatUsageFlags) const override {
    return matrix != nullptr;
  }

  void deallocate(cv::UMatData* matrix) const override {
    if (!matrix) return;
    pool_.Return(matrix->origdata, matrix->size);
    matrix->origdata = nullptr;
    delete matrix;
  }

 private:
  mutable BufferPool pool_;
};

}  // namespace

void SetUpOpenCv() {
  static std::once_flag once;
  std::call_once(once, [] {
    cv::setNumThreads(1);
    // Never destroyed: matrices of other static objects may outlive it.
    static PooledAllocator* const allocator = new PooledAllocator;
    cv::Mat::setDefaultAllocator(allocator);
  });
}

}  // namespace waymark::mapping::internal
