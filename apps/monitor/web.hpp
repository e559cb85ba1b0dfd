// SPDX-License-Identifier: Apache-2.0
/// HTTP requests and answers, independent of sockets and libraries.
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

/// The head of a request, as read by read_head() (http_message.hpp).
struct RequestHead {
  std::string method;
  /// Decoded path; begins with '/'.
  std::string path;
  std::map<std::string, std::string> query;
  /// Values by name; names are in lower case.
  std::map<std::string, std::string> headers;
  std::size_t body_size{};
  bool keep_alive{};
  /// The client uses HTTP/1.1, so a body of unknown size may be sent in chunks.
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
  /// The client uses TLS to the monitor or to a trusted proxy.
  bool secure{};
};

/// Sends a piece of an answer. Returns false if the client no longer accepts data.
using Send = std::function<bool(std::string_view piece)>;

struct WebAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  /// Sends the body in pieces, instead of `body`, until `send` returns false. Returns false if the body is incomplete.
  /// The connection is then closed, so the client detects that data is missing.
  std::function<bool(const Send& send)> stream{};
  /// Size of the stream; 0 if unknown.
  std::uint64_t stream_size{};
};

/// Reads the body of a POST: a JSON object of strings. Returns the string of each of `keys`, empty if the body does not
/// contain it. Fails with usage if the content type is not application/json, if the body is not such an object, or if
/// it contains an unknown or duplicate key.
[[nodiscard]] Result<std::map<std::string, std::string>> read_body(const WebRequest& request,
                                                                   const std::vector<std::string>& keys);

/// Returns an answer that states the reason of a refusal: {"error": "…"}.
[[nodiscard]] WebAnswer refusal(int status, std::string_view reason);

}  // namespace gyrotherm::monitor
