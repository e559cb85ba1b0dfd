// SPDX-License-Identifier: Apache-2.0
/// Parses any bytes as the head of a request. The head must either be refused or have only one interpretation.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "apps/monitor/http_message.hpp"
#include "core/text.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::monitor {

using fuzz::require;
namespace {

void take(const std::string& bytes) {
  if (const auto end = find_head_end(bytes)) require(*end <= bytes.size());
  const auto read = read_head(bytes);
  if (const auto* refused = std::get_if<HeadRefusal>(&read))
    return require(refused->status >= 400 && *refused->reason != 0);
  const auto& head = std::get<RequestHead>(read);
  require(find_head_end(bytes) == bytes.size());
  require(head.path.starts_with('/') && is_utf8(head.path) && head.path.find("/../") == std::string::npos);
  require(std::ranges::none_of(head.path, [](unsigned char c) { return c < ' '; }));
  require(head.body_size <= kMaxBodyBytes && (head.method == "GET" || head.method == "POST"));
  require(!head.headers.contains("transfer-encoding") && head.headers.size() <= kMaxHeaders);
}

}  // namespace

FUZZ_TARGET(request_head, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  take(bytes);
  take("GET /" + bytes + " HTTP/1.1\r\nHost: a\r\n\r\n");
  take("GET /a?" + bytes + " HTTP/1.1\r\nHost: a\r\n\r\n");
  take("POST /a HTTP/1.1\r\n" + bytes + "\r\n\r\n");
  take("POST /a HTTP/1.1\r\nContent-Length: " + bytes + "\r\n\r\n");
  (void)find_cookie(bytes, "session");
  return 0;
}

}  // namespace gyrotherm::monitor
