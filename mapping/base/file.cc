// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <system_error>

#include "mapping/base/internal/posix.h"

namespace waymark {
namespace {

using internal::Descriptor;
using internal::SizeOfRegularFile;
using internal::SystemError;

Error LibraryError(const std::filesystem::path& path, std::string_view action,
                   const std::error_code& failure) {
  return MakeError(ErrorCode::kUnavailable, "{}: cannot {}: {}", path.string(), action,
                   failure.message());
}

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

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
  WAYMARK_TRY_ASSIGN(const std::size_t size, SizeOfRegularFile(descriptor, path));
  Container content(size, {});
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
  const std::filesystem::path folder = FolderOf(path);
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

Result<void> DeleteFile(const std::filesystem::path& path) {
  if (::unlink(path.c_str()) != 0) {
    if (errno == ENOENT) return {};
    return SystemError(path, "delete");
  }
  return SyncFolder(FolderOf(path));
}

Result<void> DeleteFolder(const std::filesystem::path& path) {
  std::error_code failure;
  const std::uintmax_t count = std::filesystem::remove_all(path, failure);
  if (failure) return LibraryError(path, "delete", failure);
  if (count == 0) return {};
  return SyncFolder(FolderOf(path));
}

Result<void> RenameFolder(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) return SystemError(from, "rename");
  return SyncFolder(FolderOf(from));
}

Result<std::vector<std::string>> ListFolder(const std::filesystem::path& path) {
  std::vector<std::string> names;
  std::error_code failure;
  for (std::filesystem::directory_iterator entry(path, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    names.push_back(entry->path().filename().string());
  }
  if (failure && failure != std::errc::no_such_file_or_directory) {
    return LibraryError(path, "read folder", failure);
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace waymark
