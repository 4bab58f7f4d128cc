// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/gauge.h"
#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// Picks and registers images one after the other; remembers failed attempts, so that an image is
/// tried again only when it sees clearly more points than before.
class Registrar {
 public:
  Registrar(const Model& model, const SfmOptions& options);

  /// The image that sees most, best spread points and is worth trying; nullopt when none is.
  std::optional<std::uint32_t> NextImage(const Model& model) const;

  /// Estimates the image's pose from the points it sees. False: no pose, remembered.
  bool TryRegister(Model& model, std::uint32_t image, const GaugeState& gauge);

  /// Records that a registered image had to be given up.
  void Reject(const Model& model, std::uint32_t image, std::string reason);

  /// Why the last attempt failed; empty when there was none.
  const std::string& LastFailure(std::uint32_t image) const { return attempts_[image].failure; }

  /// Lets every image be tried once more.
  void ForgetAttempts();

 private:
  struct Attempt {
    int visible = 0;  // points when it failed
    std::string failure;
  };

  const SfmOptions& options_;
  std::vector<Attempt> attempts_;
};

}  // namespace waymark::mapping::internal
