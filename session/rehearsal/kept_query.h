// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "session/state/messages.h"

namespace waymark::session {

/// A question as bytes, to be asked again of another release: a line of JSON (camera, prior, up,
/// length and checksum of the image), then the image as it came. Who asked and when is not in it.
std::vector<std::uint8_t> EncodeKeptQuery(const LocaliseQuery& query);

/// Errors: Corrupt (not ours, cut off, wrong checksum, impossible camera, prior or length),
/// Unsupported (another version); messages begin with `name`.
Result<LocaliseQuery> DecodeKeptQuery(std::span<const std::uint8_t> bytes, std::string_view name);

/// The files of all questions in a folder and the folders in it, sorted. Errors: NotFound.
Result<std::vector<std::filesystem::path>> ListKeptQueries(const std::filesystem::path& folder);
/// Errors: those of files and of DecodeKeptQuery.
Result<LocaliseQuery> LoadKeptQuery(const std::filesystem::path& file);

inline constexpr std::string_view kKeptQueryEnding = ".query";

}  // namespace waymark::session
