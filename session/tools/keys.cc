// SPDX-License-Identifier: Apache-2.0
// waymark-keys: makes the keys of a service, and the tokens that let devices into rooms.
#include "session/tools/key_commands.h"

int main(int argc, char** argv) {
  return waymark::session::RunKeyCommand(argc, argv, "waymark-keys");
}
