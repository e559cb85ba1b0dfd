// SPDX-License-Identifier: Apache-2.0
/// A request and its answer, as the monitor's own code sees them: nothing of a socket or a library is in them.
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

/// The part before the body, as read_head() has accepted it (http_message.hpp).
struct RequestHead {
  std::string method;                          ///< "GET" or "POST"
  std::string path;                            ///< begins with '/'; decoded
  std::map<std::string, std::string> query;    ///< decoded
  std::map<std::string, std::string> headers;  ///< by name in small letters
  std::size_t body_size{};
  bool keep_alive{};
  bool takes_chunks{};  ///< the client speaks HTTP/1.1: what has no known size may come in chunks

  /// Empty where there is none.
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
  std::string peer;  ///< address of the client, as the connection or a trusted proxy says
  bool secure{};     ///< it came by TLS, here or at a trusted proxy
};

/// Gives a piece of an answer away; false once nobody takes it any more.
using Send = std::function<bool(std::string_view piece)>;

struct WebAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  /// Instead of the body: sends pieces until it returns, or until `send` is false. False where not all of it could be
  /// sent: the connection is closed, so that whoever reads notices.
  std::function<bool(const Send& send)> stream{};
  /// With a stream whose size is known; 0: it is not, and ends with the connection.
  std::uint64_t stream_size{};
};

/// Reads the body of a POST, a flat JSON object, and returns the texts of these keys, empty where one is missing. Fails
/// with usage if the content type is not application/json, if the body is not an object of texts, or if it has another
/// key or a duplicate one.
[[nodiscard]] Result<std::map<std::string, std::string>> read_body(const WebRequest& request,
                                                                   const std::vector<std::string>& keys);

/// Returns an answer that gives the reason of a refusal: {"error": "…"}.
[[nodiscard]] WebAnswer refusal(int status, std::string_view why);

}  // namespace gyrotherm::monitor
