// SPDX-License-Identifier: Apache-2.0
/// The head of an HTTP/1.1 request, read strictly and before anything else looks at it: what is not as RFC 9110 and
/// 9112 write it is refused, and so is what two readers could understand in two ways. Pure; bytes may be anything.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

inline constexpr std::size_t kLongestHead = 8192;    ///< bytes, with its last empty line
inline constexpr std::size_t kLongestTarget = 2048;  ///< bytes
inline constexpr std::size_t kMostHeaders = 64;
inline constexpr std::size_t kLargestBody = 4096;  ///< bytes

/// Why a request is refused, and with what status.
struct HeadRefusal {
  int status{};
  const char* why = "";
};

/// Where the head in `bytes` ends (behind its empty line); nothing while it has not come whole. A head that can be seen
/// to be too long has no end: kLongestHead is for the caller to hold.
[[nodiscard]] std::optional<std::size_t> end_of_head(std::string_view bytes);

/// Reads a whole head. Refused are, with 400: a line that ends without CR, a folded or malformed header, control
/// characters, a header twice that may come once, a target that is no path, an encoded NUL, slash or backslash, "..", a
/// body of a GET; with 405 other methods than GET and POST; 411 a POST without a length; 413 a body that is too long;
/// 414 a target, 431 a head that is; 501 any Transfer-Encoding and any Expect; 505 another version than HTTP/1.1
/// and 1.0.
[[nodiscard]] std::variant<RequestHead, HeadRefusal> read_head(std::string_view head);

/// With a to z for A to Z: names of hosts and headers are the same in both.
[[nodiscard]] std::string in_small_letters(std::string_view text);

/// "a%20b" → "a b"; '+' stays. Nothing if it is not well formed.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

/// With every byte escaped but letters, digits and - . _ ~ (RFC 3986, 2.3).
[[nodiscard]] std::string percent_encoded(std::string_view text);

/// The value of a cookie; empty where there is none of that name.
[[nodiscard]] std::string cookie_in(std::string_view header, std::string_view name);

}  // namespace gyrotherm::monitor
