#pragma once
/// Defines macros that tell which sanitizer instruments this build: GCC has predefined macros for
/// that, Clang has __has_feature.
///
/// SIGHTLINE_WATCHED_THREADS  defined with ThreadSanitizer
/// SIGHTLINE_WATCHED_HEAP     defined with ThreadSanitizer or AddressSanitizer, which replace the
///                            heap

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define SIGHTLINE_WATCHED_THREADS
#endif
#if __has_feature(address_sanitizer)
#define SIGHTLINE_WATCHED_HEAP
#endif
#endif

#if defined(__SANITIZE_THREAD__) && !defined(SIGHTLINE_WATCHED_THREADS)
#define SIGHTLINE_WATCHED_THREADS
#endif
#if (defined(__SANITIZE_ADDRESS__) || defined(SIGHTLINE_WATCHED_THREADS)) && \
    !defined(SIGHTLINE_WATCHED_HEAP)
#define SIGHTLINE_WATCHED_HEAP
#endif

// Tests: tests/unit/base/parallel_test.cpp
