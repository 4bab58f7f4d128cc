// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/index_times.h"

#include "mapping/base/file.h"
#include "mapping/pipeline/internal/json_decoding.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFormat = 1;

fs::path TimesPath(const fs::path& folder) { return folder / "times.json"; }

}  // namespace

Result<IndexTimes> LoadIndexTimes(const fs::path& experience_folder) {
  const fs::path path = TimesPath(experience_folder);
  const auto text = LoadTextFile(path);
  if (!text && text.error().code == ErrorCode::kNotFound) return IndexTimes{};
  if (!text) return text.error();
  return DecodeJson<IndexTimes>(*text, path.string(), kFormat, [](const json& body) {
    return Result<IndexTimes>(
        IndexTimes{.features_s = body.at("features_s").get<double>(),
                   .split_s = body.at("split_s").get<double>(),
                   .features_threads = body.at("features_threads").get<int>()});
  });
}

Result<void> AddIndexTimes(const fs::path& experience_folder, const IndexTimes& times) {
  WAYMARK_TRY_ASSIGN(const IndexTimes before, LoadIndexTimes(experience_folder));
  const nlohmann::ordered_json body{{"format", kFormat},
                                    {"features_s", before.features_s + times.features_s},
                                    {"split_s", before.split_s + times.split_s},
                                    {"features_threads", times.features_threads}};
  return StoreFileAtomically(TimesPath(experience_folder), std::string_view(body.dump() + "\n"));
}

}  // namespace waymark::mapping
