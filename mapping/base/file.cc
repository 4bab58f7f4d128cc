// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

namespace waymark {
namespace {

Error SystemError(const std::filesystem::path& path, std::string_view action) {
  const int reason = errno;
  return MakeError(reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
                   "{}: cannot {}: {}", path.string(), action, std::strerror(reason));
}

/// Owns a POSIX descriptor for the length of one function.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int get() const { return value_; }
  bool valid() const { return value_ >= 0; }

 private:
  int value_;
};

Result<void> SyncFolder(const std::filesystem::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!descriptor.valid()) return SystemError(folder, "open folder");
  if (::fsync(descriptor.get()) != 0) return SystemError(folder, "sync folder");
  return {};
}

template <typename Container>
Result<Container> LoadInto(const std::filesystem::path& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid()) return SystemError(path, "open");
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) return SystemError(path, "read");
  if (!S_ISREG(status.st_mode)) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected a regular file", path.string());
  }
  Container content(static_cast<std::size_t>(status.st_size), {});
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t count = ::read(descriptor.get(), content.data() + done, content.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return SystemError(path, "read");
    if (count == 0) break;  // the file shrank while we read it
    done += static_cast<std::size_t>(count);
  }
  content.resize(done);
  return content;
}

Result<void> WriteAll(int descriptor, std::span<const std::uint8_t> bytes,
                      const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return SystemError(path, "write");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Result<void> WriteDurably(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  const Descriptor descriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!descriptor.valid()) return SystemError(path, "create");
  WAYMARK_TRY(WriteAll(descriptor.get(), bytes, path));
  if (::fsync(descriptor.get()) != 0) return SystemError(path, "sync");
  return {};
}

}  // namespace

Result<std::vector<std::uint8_t>> LoadFile(const std::filesystem::path& path) {
  return LoadInto<std::vector<std::uint8_t>>(path);
}

Result<std::string> LoadTextFile(const std::filesystem::path& path) {
  return LoadInto<std::string>(path);
}

Result<void> StoreFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::uint8_t> bytes) {
  static std::atomic<unsigned> counter{0};  // keeps two threads of one process apart
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const std::filesystem::path temporary =
      folder / fmt::format(".{}.{}.{}.tmp", path.filename().string(), ::getpid(), counter++);
  auto result = WriteDurably(temporary, bytes);
  if (result && ::rename(temporary.c_str(), path.c_str()) != 0) {
    result = SystemError(path, "replace");
  }
  if (!result) {
    ::unlink(temporary.c_str());
    return result;
  }
  return SyncFolder(folder);
}

Result<void> StoreFileAtomically(const std::filesystem::path& path, std::string_view text) {
  return StoreFileAtomically(
      path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

Result<void> CreateFolders(const std::filesystem::path& path) {
  const auto absolute = std::filesystem::absolute(path).lexically_normal();
  std::filesystem::path prefix;
  for (const auto& part : absolute) {
    prefix /= part;
    if (::mkdir(prefix.c_str(), 0755) == 0) {
      WAYMARK_TRY(SyncFolder(prefix.parent_path()));
    } else if (errno != EEXIST && errno != EISDIR) {
      return SystemError(prefix, "create folder");
    }
  }
  if (!std::filesystem::is_directory(absolute)) {
    return MakeError(ErrorCode::kConflict, "{}: expected a folder, found a file", path.string());
  }
  return {};
}

Result<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.valid()) return SystemError(path, "open");
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) return SystemError(path, "read");
  if (!S_ISREG(status.st_mode)) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected a regular file", path.string());
  }
  const auto size = static_cast<std::size_t>(status.st_size);
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

Result<FileLock> FileLock::Acquire(const std::filesystem::path& path, std::string_view purpose) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) return SystemError(path, "create lock file");
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    const bool taken = errno == EWOULDBLOCK;
    const Error error = taken ? MakeError(ErrorCode::kConflict, "{}: is in use by another {}",
                                          path.parent_path().string(), purpose)
                              : SystemError(path, "lock");
    ::close(descriptor);
    return error;
  }
  return FileLock(descriptor);
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace waymark
