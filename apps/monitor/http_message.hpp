// SPDX-License-Identifier: Apache-2.0
/// HTTP/1.1 messages: reads the head of a request, and writes the head and the chunks of an answer, with Boost.Beast.
/// Stricter than the library: refuses requests that two parsers could interpret differently. Does no input or output.
/// The bytes of a request are untrusted.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

/// Limits of a request. The head includes the empty line at its end.
inline constexpr std::size_t kMaxHeadBytes = 8192;
inline constexpr std::size_t kMaxTargetBytes = 2048;
inline constexpr std::size_t kMaxHeaders = 64;
inline constexpr std::size_t kMaxBodyBytes = 4096;
/// Limits of a connection: the time between two requests, and the number of requests.
inline constexpr auto kIdleTimeout = std::chrono::seconds(3);
inline constexpr int kMaxRequests = 100;

/// HTTP status and reason of a refused head.
struct HeadRefusal {
  int status{};
  const char* reason = "";
};

/// Returns the offset after the empty line that ends the head, or nothing if the head is incomplete. The caller
/// enforces kMaxHeadBytes.
[[nodiscard]] std::optional<std::size_t> find_head_end(std::string_view bytes);

/// Reads a complete head. Refuses it with
/// 400: a head that is not HTTP, a line that does not end with CR LF, a folded header, a control character, a duplicate
///      header that is not a list, a target that is not a path, an encoded NUL, slash or backslash, "..", a
///      Content-Length that is not a number, a GET with a body;
/// 405: a method other than GET and POST;        411: a POST without Content-Length;
/// 413, 414, 431: too long a body, target, head;
/// 501: Transfer-Encoding, Expect, Upgrade;      505: a version other than HTTP/1.1 and 1.0.
[[nodiscard]] std::variant<RequestHead, HeadRefusal> read_head(std::string_view head);

/// Returns whether the body of `answer` is sent in chunks: its size is unknown, and the client supports chunks. For a
/// client that does not, the end of the connection ends the body (RFC 9112, 6.3).
[[nodiscard]] bool is_chunked(const WebAnswer& answer, const RequestHead& request);

/// Returns the status line and the headers of the answer to a request.
[[nodiscard]] std::string answer_head(const WebAnswer& answer, const RequestHead& request);

/// Encodes a piece of a body as a chunk. An empty piece gives the last chunk.
[[nodiscard]] std::string encode_chunk(std::string_view piece);

/// Converts ASCII letters to lower case, for host and header names, which are case-insensitive.
[[nodiscard]] std::string to_lower_case(std::string_view text);

/// Decodes "a%20b" to "a b"; '+' is unchanged. Returns nothing if an escape is malformed, or if the result contains
/// control characters or invalid UTF-8.
[[nodiscard]] std::optional<std::string> percent_decode(std::string_view text);

/// Escapes every byte except letters, digits and - . _ ~ (RFC 3986, 2.3).
[[nodiscard]] std::string percent_encode(std::string_view text);

/// Returns the value of a cookie, or an empty text if the header does not contain it.
[[nodiscard]] std::string find_cookie(std::string_view header, std::string_view name);

}  // namespace gyrotherm::monitor
