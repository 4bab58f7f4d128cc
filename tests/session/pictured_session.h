// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>

#include "session/server/map_localiser.h"
#include "tests/localiser/map_on_disk.h"
#include "tests/session/pictured_map.h"
#include "tests/session/session_fixture.h"

namespace waymark::session::support {

/// A server with a real localiser, in a map of one picture.
class PicturedSession : public SessionTest {
 protected:
  PicturedSession() {
    const auto features = mapping::ExtractFeatures({kPictureWidth, kPictureHeight, Picture()}, {});
    disk_.Add(MapOf(*features));
    disk_.release().created_utc = "2024-01-01T00:00:00Z";
    EXPECT_TRUE(disk_.map().StoreRelease(disk_.release()).ok());
    EXPECT_TRUE(disk_.map().Deploy(1).ok());
  }

  /// Serves the map, or what says to be another release of it.
  void Serve(std::uint64_t epoch = 1) {
    mapping::Release release = disk_.release();
    release.epoch = epoch;
    const auto localise =
        MakeLocaliseFunction(*localiser::Localiser::Create(disk_.map(), release, {}),
                             disk_.map().description(), std::make_shared<UnfoundImages>());
    options_.dds_domain = domain_;
    server_ = StartOnFreeDomain(options_, [&] {
      ServerParts parts = MakeParts(release);
      parts.map = disk_.map().description();
      parts.served.localise =
          [this, localise](const LocaliseQuery& query) -> Result<localiser::Localisation> {
        last_query_bytes_ = query.image.size();
        is_last_query_features_ =
            std::string(query.image.begin(), query.image.begin() + 8) == "WAYMFEAT";
        return localise(query);
      };
      return parts;
    });
    ASSERT_NE(server_, nullptr);
    domain_ = options_.dds_domain;
    if (UsesGateway() && gateway_ == nullptr) StartGateway();
  }

  localiser::MapOnDisk disk_;
  std::atomic<std::size_t> last_query_bytes_ = 0;
  std::atomic<bool> is_last_query_features_ = false;
};

}  // namespace waymark::session::support
