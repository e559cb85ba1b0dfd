// SPDX-License-Identifier: Apache-2.0
/// HTTP/1.1 messages as text, with Boost.Beast: reads the head of a request, and writes the head and the chunks of an
/// answer. It is stricter than the library: it refuses requests that two parsers could interpret differently. Pure. The
/// bytes of a request are untrusted.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "apps/monitor/web.hpp"

namespace gyrotherm::monitor {

/// Limits of a request; sizes in bytes. The head includes its empty line.
inline constexpr std::size_t kMaxHeadBytes = 8192;
inline constexpr std::size_t kMaxTargetBytes = 2048;
inline constexpr std::size_t kMaxHeaders = 64;
inline constexpr std::size_t kMaxBodyBytes = 4096;
/// Limits of a connection: time between requests, and number of requests.
inline constexpr auto kIdleTimeout = std::chrono::seconds(3);
inline constexpr int kMaxRequests = 100;

/// The reason for a refusal and the status of its answer.
struct HeadRefusal {
  int status{};
  const char* why = "";
};

/// Returns the end of the head in `bytes`, after its empty line, or nothing while the head is incomplete. The caller
/// enforces kMaxHeadBytes.
[[nodiscard]] std::optional<std::size_t> find_head_end(std::string_view bytes);

/// Reads a whole head. Refuses it with
/// 400: a head that does not parse, a line that ends without CR, a folded header, control characters, a duplicate
///      header except a list, a target that is not a path, an encoded NUL, slash or backslash, "..", a Content-Length
///      that is not one number, a body of a GET;
/// 405: other methods than GET and POST;     411: a POST without a length;
/// 413, 414, 431: a body, a target, a head that is too long;
/// 501: Transfer-Encoding, Expect, Upgrade;  505: other versions than HTTP/1.1 and 1.0.
[[nodiscard]] std::variant<RequestHead, HeadRefusal> read_head(std::string_view head);

/// Returns whether the body of `answer` is sent in chunks. If the client does not support chunks, a stream of unknown
/// size ends with the connection (RFC 9112, 6.3).
[[nodiscard]] bool is_chunked(const WebAnswer& answer, const RequestHead& to);

/// Writes the status line and the headers of an answer to the request `to`.
[[nodiscard]] std::string answer_head(const WebAnswer& answer, const RequestHead& to);

/// Returns a chunk. An empty one is the last.
[[nodiscard]] std::string chunk(std::string_view piece);

/// Returns the text in lower case (ASCII letters). Names of hosts and headers are case-insensitive.
[[nodiscard]] std::string to_lower_case(std::string_view text);

/// Decodes "a%20b" to "a b". '+' is unchanged. Returns nothing if the text is malformed.
[[nodiscard]] std::optional<std::string> percent_decode(std::string_view text);

/// Escapes every byte except letters, digits and - . _ ~ (RFC 3986, 2.3).
[[nodiscard]] std::string percent_encode(std::string_view text);

/// Returns the value of a cookie, or an empty text if the header does not contain it.
[[nodiscard]] std::string find_cookie(std::string_view header, std::string_view name);

}  // namespace gyrotherm::monitor
