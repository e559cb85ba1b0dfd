// SPDX-License-Identifier: Apache-2.0
/// A request and its answer, independent of sockets and libraries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::monitor {

/// The head of a request as accepted by read_head() (http_message.hpp).
struct RequestHead {
  std::string method;
  /// Decoded path; begins with '/'.
  std::string path;
  std::map<std::string, std::string> query;
  /// Keyed by name in lower case.
  std::map<std::string, std::string> headers;
  std::size_t body_size{};
  bool keep_alive{};
  /// The client supports HTTP/1.1, so answers of unknown size may be sent in chunks.
  bool accepts_chunks{};

  /// Return the value of a header or parameter, or an empty text.
  [[nodiscard]] std::string header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
  }
  [[nodiscard]] std::string parameter(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string() : found->second;
  }
};

struct WebRequest {
  RequestHead head;
  std::string body;
  /// Address of the client, from the connection or a trusted proxy.
  std::string peer;
  /// Received by TLS, here or at a trusted proxy.
  bool secure{};
};

/// Sends a piece of an answer. Returns false if the client no longer accepts data.
using Send = std::function<bool(std::string_view piece)>;

struct WebAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  /// Replaces the body. The function sends pieces by `send` and stops if `send` returns false. It returns false if the
  /// answer is incomplete; the connection is then closed, which shows the client that data is missing.
  std::function<bool(const Send& send)> stream{};
  /// Size of the stream; 0 if unknown.
  std::uint64_t stream_size{};
};

/// Reads the body of a POST, a flat JSON object, and returns the texts of these keys, empty for a missing key. Fails
/// with usage if the content type is not application/json, if the body is not an object of texts, or if it has another
/// key or a duplicate one.
[[nodiscard]] Result<std::map<std::string, std::string>> read_body(const WebRequest& request,
                                                                   const std::vector<std::string>& keys);

/// Returns an answer with the reason of a refusal: {"error": "…"}.
[[nodiscard]] WebAnswer refusal(int status, std::string_view why);

}  // namespace gyrotherm::monitor
