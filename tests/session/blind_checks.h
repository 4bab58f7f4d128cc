// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace waymark::session::support {

/// What a process has its own plug-ins of DDS Security read in governance and permissions, where
/// blind_checks.cc is linked. What goes to others is as it was.
struct Pretence {
  std::string words = {};  ///< empty: nothing is changed
  std::string instead = {};
};
Pretence& ThePretence();

}  // namespace waymark::session::support
