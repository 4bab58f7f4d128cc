// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::mapping {

using Bytes = std::vector<std::uint8_t>;

// The layout once more, from mapping/FORMAT.md rather than from the code under test.
constexpr std::size_t kHeader = 4096, kTable = 64, kEntry = 32, kSections = 9;

template <typename T>
T Get(const Bytes& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

template <typename T>
void Set(Bytes& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

inline std::size_t SectionOffset(const Bytes& bytes, std::size_t section) {
  return Get<std::uint64_t>(bytes, kTable + section * kEntry + 8);
}

inline std::size_t SectionSize(const Bytes& bytes, std::size_t section) {
  return Get<std::uint64_t>(bytes, kTable + section * kEntry + 16) *
         Get<std::uint32_t>(bytes, kTable + section * kEntry + 4);
}

/// A submap file of the test's own.
class SubmapFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string("submap_file.") +
             testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  Result<SubmapView> OpenAfterWriting(const Bytes& bytes,
                                      SubmapReading reading = SubmapReading::kWhole) const {
    EXPECT_TRUE(StoreFileAtomically(path_, bytes));
    return SubmapView::Open(path_, reading);
  }

  std::filesystem::path path_;
};

}  // namespace waymark::mapping
