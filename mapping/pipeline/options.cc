// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/pipeline.h"

#include <cmath>

namespace waymark::mapping {

Result<void> PipelineOptions::Validate() const {
  WAYMARK_TRY(features.Validate());
  WAYMARK_TRY(split.Validate());
  WAYMARK_TRY(pairing.Validate());
  WAYMARK_TRY(matching.Validate());
  WAYMARK_TRY(search.Validate());
  WAYMARK_TRY(sfm.Validate());
  WAYMARK_TRY(verification.Validate());
  WAYMARK_TRY(assembly.Validate());
  WAYMARK_TRY(fusion.Validate());
  for (const auto& [camera, seconds] : readout_s) {
    if (std::abs(seconds) < 1) continue;
    return MakeError(ErrorCode::kInvalidArgument,
                     "readout of camera \"{}\": expected less than a second, found {} s", camera,
                     seconds);
  }
  if (parallelism.threads < 0) {
    return MakeError(ErrorCode::kInvalidArgument, "threads: expected 0 or more, found {}",
                     parallelism.threads);
  }
  return {};
}

Result<void> SlurmOptions::Validate() const {
  if (!program.is_absolute()) {
    return MakeError(ErrorCode::kInvalidArgument, "program: expected an absolute path, found {}",
                     program.string());
  }
  if (threads < 1 || rounds < 1 || poll.count() < 1) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "threads, rounds, poll: expected 1 or more, found {}, {}, {} ms", threads,
                     rounds, poll.count());
  }
  return {};
}

std::string_view PipelineStageName(PipelineStage stage) {
  switch (stage) {
    case PipelineStage::kFeatures:
      return "features";
    case PipelineStage::kMatching:
      return "matching";
    case PipelineStage::kReconstruction:
      return "reconstruction";
    case PipelineStage::kSubmaps:
      return "submaps";
    case PipelineStage::kFusion:
      return "fusion";
  }
  return "?";
}

}  // namespace waymark::mapping
