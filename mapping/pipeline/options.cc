// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/pipeline.h"

namespace waymark::mapping {

Result<void> PipelineOptions::Validate() const {
  WAYMARK_TRY(features.Validate());
  WAYMARK_TRY(split.Validate());
  WAYMARK_TRY(pairing.Validate());
  WAYMARK_TRY(matching.Validate());
  WAYMARK_TRY(sfm.Validate());
  WAYMARK_TRY(verification.Validate());
  WAYMARK_TRY(assembly.Validate());
  WAYMARK_TRY(fusion.Validate());
  if (parallelism.threads < 0) {
    return MakeError(ErrorCode::kInvalidArgument, "threads: expected 0 or more, found {}",
                     parallelism.threads);
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
