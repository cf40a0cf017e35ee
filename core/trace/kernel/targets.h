#pragma once
/// Selects the instruction sets for which Highway compiles kernels. Must be included before any
/// header of Highway.
///
/// SSSE3 is left out, because it is no faster than SSE4 here. Scalable vectors (SVE) cannot be
/// members of a structure; processors that have them run the kernel for NEON.

#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#endif

// Tests: tests/unit/trace/kernel_test.cpp
