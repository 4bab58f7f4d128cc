// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "localiser/localiser.h"
#include "mapping/base/result.h"
#include "session/state/messages.h"

namespace waymark::session {

struct UnfoundImagesOptions {
  std::size_t max_bytes = std::size_t{256} * 1024 * 1024;  ///< of features; the oldest go first
  std::chrono::duration<double> max_age{60};               ///< > 0

  Result<void> Validate() const;
};

/// Images that phones asked about and that were not found, as features, for the moment when a later
/// one names them. Holds of a phone what its last query named, and that query's own image: 16 at
/// most. What is too old goes when the next image comes, whosever it is. Thread-safe.
class UnfoundImages {
 public:
  using Instant = std::chrono::steady_clock::time_point;
  using Request = std::shared_ptr<const localiser::LocalisationRequest>;

  explicit UnfoundImages(const UnfoundImagesOptions& options = {}) : options_(options) {}

  /// An image and where the query's odometry saw it.
  struct Named {
    Request request;
    Transform<Vo, Camera> vo_from_camera;
  };
  /// Those that the query names and that are still there, in its order. All others of the phone
  /// are forgotten.
  std::vector<Named> Find(const LocaliseQuery& query, Instant now);
  /// Shapes: the request holds features
  void Keep(const LocaliseQuery& query, Request request, Instant now);
  void Forget(Ticket phone);

  std::size_t bytes() const;

 private:
  using Key = std::pair<Ticket, RequestNumber>;
  struct Image {
    Key key;
    Request request;
    std::size_t bytes;
    Instant since;
  };
  using Images = std::list<Image>;

  // mutex_ is held.
  void Drop(std::map<Key, Images::iterator>::iterator entry);
  void DropOld(Instant now);

  const UnfoundImagesOptions options_;
  mutable std::mutex mutex_;
  Images images_;                             // oldest first; guarded by mutex_
  std::map<Key, Images::iterator> by_phone_;  // guarded by mutex_
  std::size_t bytes_ = 0;                     // guarded by mutex_
};

}  // namespace waymark::session
