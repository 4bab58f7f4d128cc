// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Before a function of plain loops: the compiler makes one for each width of vector registers, and
/// the processor's is chosen when the program starts. Not for code that has Eigen's types: their
/// alignment differs.
#if defined(__x86_64__)
#define WAYMARK_CLONES __attribute__((target_clones("arch=skylake-avx512", "avx2", "default")))
#else
#define WAYMARK_CLONES
#endif
