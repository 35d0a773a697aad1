#ifndef INSONIFY_TESTS_THREAD_SANITIZER_HPP
#define INSONIFY_TESTS_THREAD_SANITIZER_HPP

/// Whether the thread sanitizer is on, under which tests take fifteen times as long: there one case of many that run the
/// same code is enough, for their numbers do not depend on it.
#if defined(__SANITIZE_THREAD__)
inline constexpr bool thread_sanitizer = true;
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
inline constexpr bool thread_sanitizer = true;
#else
inline constexpr bool thread_sanitizer = false;
#endif
#else
inline constexpr bool thread_sanitizer = false;
#endif

#endif
