// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"

namespace waymark {

/// Reads a whole file. Errors: NotFound, Unavailable (cannot be read), each naming the path.
Result<std::vector<std::uint8_t>> LoadFile(const std::filesystem::path& path);
Result<std::string> LoadTextFile(const std::filesystem::path& path);

/// Replaces a file so that after a crash either the old or the whole new content is there:
/// temporary file in the same folder, fsync, rename, fsync of the folder.
/// Errors: Unavailable with the path and the system's reason (full disk, no permission).
Result<void> StoreFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::uint8_t> bytes);
Result<void> StoreFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Creates a folder and its parents and makes their existence durable.
Result<void> CreateFolders(const std::filesystem::path& path);

/// Deletes, durably before they return. What is not there is no error.
/// Errors: Unavailable with the path and the system's reason.
Result<void> DeleteFile(const std::filesystem::path& path);
Result<void> DeleteFolder(const std::filesystem::path& path);

/// Gives a folder another name beside its own, durably before it returns.
/// Errors: NotFound, Unavailable.
Result<void> RenameFolder(const std::filesystem::path& from, const std::filesystem::path& to);

/// Names of everything in a folder, hidden ones too, sorted; none when there is no such folder.
/// Errors: Unavailable with the path and the system's reason.
Result<std::vector<std::string>> ListFolder(const std::filesystem::path& path);

}  // namespace waymark
