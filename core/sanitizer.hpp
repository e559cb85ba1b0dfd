// SPDX-License-Identifier: Apache-2.0
/// States whether the program is built with AddressSanitizer or ThreadSanitizer, by GCC or Clang. A sanitizer reserves
/// terabytes of address space, so limits of memory are not set then.
#pragma once

namespace gyrotherm {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kIsSanitizerBuild = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kIsSanitizerBuild = true;
#else
inline constexpr bool kIsSanitizerBuild = false;
#endif
#else
inline constexpr bool kIsSanitizerBuild = false;
#endif

}  // namespace gyrotherm
