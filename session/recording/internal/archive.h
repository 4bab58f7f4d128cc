// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/reader.h"
#include "session/recording/internal/writer.h"

/// Plain values as bytes and back, to the bit. Little-endian, nothing aligned; texts, sequences,
/// sets and maps begin with a 32-bit count, options and outcomes with one byte, variants with their
/// index in one byte.
namespace waymark::session::recording::internal {}
