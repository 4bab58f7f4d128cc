// SPDX-License-Identifier: Apache-2.0
#include "session/dds/entity.h"

#include <dds/dds.h>

namespace waymark::session::dds {

Result<Entity> Entity::Adopt(std::int32_t handle_or_code, std::string_view object) {
  if (handle_or_code < 0) return ErrorFromCode(handle_or_code, object);
  return Entity(handle_or_code);
}

void Entity::Reset() noexcept {
  if (handle_ > 0) (void)dds_delete(handle_);
  handle_ = 0;
}

Error ErrorFromCode(std::int32_t code, std::string_view object) {
  CHECK(code < 0, "{} is no DDS error", code);
  const auto classify = [code] {
    switch (code) {
      case DDS_RETCODE_TIMEOUT:
        return ErrorCode::kTimeout;
      case DDS_RETCODE_BAD_PARAMETER:
      case DDS_RETCODE_INCONSISTENT_POLICY:
        return ErrorCode::kInvalidArgument;
      case DDS_RETCODE_UNSUPPORTED:
        return ErrorCode::kUnsupported;
      default:
        return ErrorCode::kUnavailable;
    }
  };
  return MakeError(classify(), "{}: DDS says \"{}\"", object, dds_strretcode(code));
}

}  // namespace waymark::session::dds
