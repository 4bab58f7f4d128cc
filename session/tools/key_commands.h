// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace waymark::session {

/// Makes, issues and revokes keys and tokens, as the command line says. `program` is what its user
/// called. Returns the status to exit with; says on standard error what went wrong.
int RunKeyCommand(int argc, char** argv, const std::string& program);

}  // namespace waymark::session
