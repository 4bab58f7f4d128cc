// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::bench {

/// Processor time that this process and its descendants, a database server among them, have had so
/// far, in seconds. Says less than a clock about a disk, and more on a machine that others use.
double ProcessorSeconds();

}  // namespace waymark::bench
