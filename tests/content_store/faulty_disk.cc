// SPDX-License-Identifier: Apache-2.0
#include "tests/content_store/faulty_disk.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace waymark::content {
namespace {

namespace fs = std::filesystem;

FaultyDisk* g_disk = nullptr;
sqlite3_vfs* g_real = nullptr;
sqlite3_vfs g_vfs;

/// An open file: SQLite's part, then ours; the real one lies behind it.
struct File {
  sqlite3_file base;
  std::string* path;  // absent: not watched
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File* Of(sqlite3_file* file) { return reinterpret_cast<File*>(file); }
sqlite3_file* Real(sqlite3_file* file) { return Of(file)->real(); }
const sqlite3_io_methods* Methods(sqlite3_file* file) { return Real(file)->pMethods; }

/// What the file has there now, less at its end.
std::vector<char> Present(sqlite3_file* file, sqlite3_int64 offset, sqlite3_int64 count) {
  sqlite3_int64 size = 0;
  Methods(file)->xFileSize(Real(file), &size);
  std::vector<char> bytes(
      static_cast<std::size_t>(std::clamp<sqlite3_int64>(size - offset, 0, count)));
  if (!bytes.empty()) {
    Methods(file)->xRead(Real(file), bytes.data(), static_cast<int>(bytes.size()), offset);
  }
  return bytes;
}

int Close(sqlite3_file* file) {
  delete Of(file)->path;
  return Methods(file)->xClose(Real(file));
}
int Read(sqlite3_file* file, void* bytes, int count, sqlite3_int64 offset) {
  return Methods(file)->xRead(Real(file), bytes, count, offset);
}
int Write(sqlite3_file* file, const void* bytes, int count, sqlite3_int64 offset) {
  DiskFault fault = DiskFault::kNone;
  if (g_disk != nullptr && Of(file)->path != nullptr) {
    fault = g_disk->OnWrite(*Of(file)->path, Present(file, offset, count), offset);
  }
  if (fault == DiskFault::kFull) return SQLITE_FULL;
  if (fault == DiskFault::kWrite) return SQLITE_IOERR_WRITE;
  if (fault == DiskFault::kTorn) {
    (void)Methods(file)->xWrite(Real(file), bytes, count / 3, offset);
    return SQLITE_IOERR_WRITE;
  }
  return Methods(file)->xWrite(Real(file), bytes, count, offset);
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  if (g_disk != nullptr && Of(file)->path != nullptr) {
    g_disk->OnTruncate(*Of(file)->path, Present(file, 0, sqlite3_int64{1} << 40));
  }
  return Methods(file)->xTruncate(Real(file), size);
}
int Sync(sqlite3_file* file, int flags) {
  DiskFault fault = DiskFault::kNone;
  if (g_disk != nullptr && Of(file)->path != nullptr) fault = g_disk->OnSync(*Of(file)->path);
  if (fault == DiskFault::kSync) return SQLITE_IOERR_FSYNC;
  if (fault == DiskFault::kLostSync) return SQLITE_OK;
  return Methods(file)->xSync(Real(file), flags);
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Methods(file)->xFileSize(Real(file), size);
}
int Lock(sqlite3_file* file, int level) { return Methods(file)->xLock(Real(file), level); }
int Unlock(sqlite3_file* file, int level) { return Methods(file)->xUnlock(Real(file), level); }
int CheckReserved(sqlite3_file* file, int* out) {
  return Methods(file)->xCheckReservedLock(Real(file), out);
}
int FileControl(sqlite3_file* file, int what, void* argument) {
  return Methods(file)->xFileControl(Real(file), what, argument);
}
int SectorSize(sqlite3_file* file) { return Methods(file)->xSectorSize(Real(file)); }
int Characteristics(sqlite3_file* file) {
  return Methods(file)->xDeviceCharacteristics(Real(file));
}
int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** out) {
  return Methods(file)->xShmMap(Real(file), page, size, extend, out);
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Methods(file)->xShmLock(Real(file), offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) { Methods(file)->xShmBarrier(Real(file)); }
int ShmUnmap(sqlite3_file* file, int is_delete) {
  return Methods(file)->xShmUnmap(Real(file), is_delete);
}

const sqlite3_io_methods kMethods = {
    2,        Close,         Read,        Write,      Truncate,        Sync,   FileSize, Lock,
    Unlock,   CheckReserved, FileControl, SectorSize, Characteristics, ShmMap, ShmLock,  ShmBarrier,
    ShmUnmap, nullptr,       nullptr};

int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  Of(file)->base.pMethods = nullptr;
  Of(file)->path = nullptr;
  const int result = g_real->xOpen(g_real, name, Real(file), flags, out_flags);
  if (Methods(file) == nullptr) return result;
  if (name != nullptr && g_disk != nullptr && g_disk->Watches(name)) {
    Of(file)->path = new std::string(name);
  }
  Of(file)->base.pMethods = &kMethods;
  return result;
}

int Delete(sqlite3_vfs*, const char* name, int is_synced) {
  if (g_disk != nullptr && g_disk->Watches(name)) g_disk->OnDelete(name);
  return g_real->xDelete(g_real, name, is_synced);
}

}  // namespace

FaultyDisk::FaultyDisk(fs::path folder) : folder_(std::move(folder)) {
  g_disk = this;
  g_real = sqlite3_vfs_find(nullptr);
  g_vfs = *g_real;
  g_vfs.szOsFile = static_cast<int>(sizeof(File)) + g_real->szOsFile;
  g_vfs.pNext = nullptr;
  g_vfs.zName = "waymark-faulty";
  g_vfs.xOpen = Open;
  g_vfs.xDelete = Delete;
  EXPECT_EQ(sqlite3_vfs_register(&g_vfs, 1), SQLITE_OK);
}

FaultyDisk::~FaultyDisk() {
  sqlite3_vfs_register(g_real, 1);
  sqlite3_vfs_unregister(&g_vfs);
  g_disk = nullptr;
}

void FaultyDisk::Plan(DiskFault fault, std::uint64_t at) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
  left_ = at;
  has_struck_ = false;
}

DiskFault FaultyDisk::OnWrite(const std::string& path, const std::vector<char>& before,
                              std::int64_t offset) {
  const std::lock_guard lock(mutex_);
  const bool is_of_writes =
      fault_ == DiskFault::kFull || fault_ == DiskFault::kTorn || fault_ == DiskFault::kWrite;
  const bool strikes = is_of_writes && left_ > 0 && --left_ == 0;
  has_struck_ = has_struck_ || strikes;
  unsynced_[path].push_back({offset, before});
  return strikes ? fault_ : DiskFault::kNone;
}

DiskFault FaultyDisk::OnSync(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (fault_ == DiskFault::kSync && left_ > 0 && --left_ == 0) {
    has_struck_ = true;
    return DiskFault::kSync;
  }
  if (fault_ == DiskFault::kLostSync && (left_ <= 1 || --left_ == 0)) {
    has_struck_ = true;
    return DiskFault::kLostSync;
  }
  unsynced_.erase(path);
  return DiskFault::kNone;
}

void FaultyDisk::OnTruncate(const std::string& path, const std::vector<char>& before) {
  const std::lock_guard lock(mutex_);
  unsynced_[path].push_back({0, before});
}

void FaultyDisk::OnDelete(const std::string& path) {
  const std::lock_guard lock(mutex_);
  unsynced_.erase(path);
}

void FaultyDisk::Cut(const fs::path& into, std::mt19937_64& random) {
  constexpr std::size_t kSector = 512;
  const std::lock_guard lock(mutex_);
  std::bernoulli_distribution lost(std::uniform_real_distribution<double>(0, 1)(random));
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("-shm")) continue;  // says nothing that recovery does not find out
    std::ifstream in(entry.path(), std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    auto& writes = unsynced_[entry.path().string()];
    for (auto write = writes.rbegin(); write != writes.rend();
         ++write) {  // the latest is undone first
      for (std::size_t at = 0; at < write->bytes.size(); at += kSector) {
        if (!lost(random)) continue;
        const std::size_t end = std::min(at + kSector, write->bytes.size());
        const auto begin = static_cast<std::size_t>(write->offset) + at;
        if (bytes.size() < begin + end - at) bytes.resize(begin + end - at, '\0');
        std::copy(write->bytes.begin() + static_cast<std::ptrdiff_t>(at),
                  write->bytes.begin() + static_cast<std::ptrdiff_t>(end),
                  bytes.begin() + static_cast<std::ptrdiff_t>(begin));
      }
      // What lay beyond the file's end before may not have been written at all.
      if (write->bytes.empty() && lost(random)) {
        const auto begin = static_cast<std::size_t>(write->offset);
        const std::size_t end = std::min(bytes.size(), begin + kSector);
        if (begin < end)
          std::fill(bytes.begin() + std::ptrdiff_t(begin), bytes.begin() + std::ptrdiff_t(end),
                    '\0');
      }
    }
    std::ofstream(into / name, std::ios::binary) << bytes;
  }
}

}  // namespace waymark::content
