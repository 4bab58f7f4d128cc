// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <utility>

#include "mapping/base/internal/posix.h"

namespace waymark {

using internal::Descriptor;
using internal::SizeOfRegularFile;
using internal::SystemError;

Result<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid()) return SystemError(path, "open");
  WAYMARK_TRY_ASSIGN(const std::size_t size, SizeOfRegularFile(descriptor, path));
  if (size == 0) return MappedFile(nullptr, 0);
  void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor.get(), 0);
  if (data == MAP_FAILED) return SystemError(path, "map into memory");
  return MappedFile(static_cast<const std::uint8_t*>(data), size);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::uint8_t*>(data_), size_);
}

}  // namespace waymark
