#pragma once
/// Selects the instruction sets for which Highway compiles kernels. Must be included before any
/// header of Highway.
///
/// SSSE3 is left out, because it is no faster than SSE4 here, and so are the variants of AVX-512 of
/// newer versions of Highway, which no kernel is named for. Scalable vectors (SVE) cannot be
/// members of a structure; processors that have them run the kernel for NEON.

// A build with sanitizers defines it too.
#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | SIGHTLINE_AVX512_VARIANTS)
#endif
#include <hwy/detect_targets.h>
#ifdef HWY_AVX3_SPR
#define SIGHTLINE_AVX512_VARIANTS (HWY_AVX3_ZEN4 | HWY_AVX3_SPR)
#else
#define SIGHTLINE_AVX512_VARIANTS 0
#endif

// Tests: tests/unit/trace/kernel_test.cpp
