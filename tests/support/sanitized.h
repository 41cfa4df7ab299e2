// Whether a test runs under AddressSanitizer or ThreadSanitizer, which have allocators of their
// own. GCC says so by a macro, Clang by a feature.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DACRT_TEST_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define DACRT_TEST_SANITIZED 1
#endif
#endif
#ifndef DACRT_TEST_SANITIZED
#define DACRT_TEST_SANITIZED 0
#endif
