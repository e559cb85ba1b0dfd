// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/http_message.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/http/chunk_encode.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/serializer.hpp>
#include <cctype>
#include <charconv>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

namespace http = boost::beast::http;
using boost::asio::const_buffer;

/// Headers of every answer: the page loads only its own files, cannot be framed, and is not cached.
constexpr std::array<std::pair<const char*, const char*>, 8> kCommonHeaders{
    {{"Cache-Control", "no-store"},
     {"Content-Security-Policy",
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
      "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
     {"Cross-Origin-Opener-Policy", "same-origin"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Permissions-Policy", "camera=(), microphone=(), geolocation=()"},
     {"Referrer-Policy", "no-referrer"},
     {"X-Content-Type-Options", "nosniff"},
     {"X-Frame-Options", "DENY"}}};

std::string_view to_view(boost::beast::string_view text) { return {text.data(), text.size()}; }

bool is_printable(char c) { return c > ' ' && c < 0x7F; }

/// Returns the value of a hexadecimal digit, or −1.
int hex_digit_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

using OptionalRefusal = std::optional<HeadRefusal>;

OptionalRefusal read_query(std::string_view text, RequestHead& head) {
  while (!text.empty()) {
    const auto end = std::min(text.find('&'), text.size());
    const auto pair = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = std::min(pair.find('='), pair.size());
    const auto name = percent_decode(pair.substr(0, equals));
    const auto value = percent_decode(pair.substr(std::min(equals + 1, pair.size())));
    if (!name || !value) return HeadRefusal{400, "the query is not valid percent-encoded UTF-8"};
    if (!head.query.emplace(*name, *value).second) return HeadRefusal{400, "duplicate query parameter"};
  }
  return std::nullopt;
}

/// Returns whether a segment of the path is "." or "..", or contains a backslash.
bool has_unsafe_segment(std::string_view path) {
  while (!path.empty()) {
    path.remove_prefix(1);
    const auto end = std::min(path.find('/'), path.size());
    const auto segment = path.substr(0, end);
    if (segment == "." || segment == ".." || segment.find('\\') != std::string_view::npos) return true;
    path.remove_prefix(end);
  }
  return false;
}

OptionalRefusal read_target(std::string_view target, RequestHead& head) {
  if (target.size() > kMaxTargetBytes) return HeadRefusal{414, "the target is too long"};
  if (!target.starts_with('/') || target.starts_with("//")) return HeadRefusal{400, "the target is not a path"};
  if (!std::ranges::all_of(target, is_printable)) return HeadRefusal{400, "the target contains invalid characters"};
  if (target.find('#') != std::string_view::npos) return HeadRefusal{400, "the target has a fragment"};
  const auto query_begin = std::min(target.find('?'), target.size());
  const auto encoded_path = target.substr(0, query_begin);
  const auto path = percent_decode(encoded_path);
  const bool has_encoded_slash = std::count(encoded_path.begin(), encoded_path.end(), '/') !=
                                 (path ? std::count(path->begin(), path->end(), '/') : -1);
  if (!path || has_encoded_slash || has_unsafe_segment(*path)) return HeadRefusal{400, "invalid path"};
  head.path = *path;
  return read_query(target.substr(std::min(query_begin + 1, target.size())), head);
}

OptionalRefusal read_header(std::string_view name, std::string_view value, RequestHead& head) {
  if (head.headers.size() >= kMaxHeaders) return HeadRefusal{431, "too many headers"};
  const auto [found, is_new] = head.headers.emplace(to_lower_case(name), value);
  if (is_new) return std::nullopt;
  constexpr std::array kLists{"accept", "accept-encoding", "accept-language", "cache-control",
                              "via",    "x-forwarded-for"};
  if (std::ranges::find(kLists, found->first) == kLists.end()) return HeadRefusal{400, "duplicate header"};
  // A list (RFC 9110, 5.3).
  found->second.append(", ").append(value);
  return std::nullopt;
}

OptionalRefusal read_body_size(RequestHead& head) {
  if (head.headers.contains("transfer-encoding"))
    return HeadRefusal{501, "Transfer-Encoding: header not supported; send Content-Length"};
  if (head.headers.contains("expect")) return HeadRefusal{501, "Expect: header not supported"};
  if (head.headers.contains("upgrade")) return HeadRefusal{501, "Upgrade: header not supported"};
  const auto length = head.headers.find("content-length");
  if (length == head.headers.end())
    return head.method == "POST" ? OptionalRefusal(HeadRefusal{411, "Content-Length is missing; a POST requires it"})
                                 : std::nullopt;
  const auto& text = length->second;
  if (text.empty() || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }))
    return HeadRefusal{400, "Content-Length is not a number"};
  constexpr std::size_t kLongestNumber = 9;
  if (text.size() > kLongestNumber) return HeadRefusal{413, "the body is too long"};
  std::from_chars(text.data(), text.data() + text.size(), head.body_size);
  if (head.method == "GET" && head.body_size > 0) return HeadRefusal{400, "a GET must not have a body"};
  return head.body_size > kMaxBodyBytes ? OptionalRefusal(HeadRefusal{413, "the body is too long"}) : std::nullopt;
}

/// Returns whether the request line is METHOD TARGET HTTP/x.y.
bool has_http_version(std::string_view head) {
  const auto line = head.substr(0, head.find("\r\n"));
  const auto version = line.substr(line.rfind(' ') + 1);
  return std::ranges::count(line, ' ') == 2 && version.starts_with("HTTP/") && version.size() == 8;
}

/// Returns whether the value of a Content-Length line is a number too large for Beast.
bool is_oversized_length(std::string_view line) {
  const auto value = trimmed(line.substr(line.find(':') + 1, line.find('\r') - line.find(':') - 1));
  return value.size() > 19 && value.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Returns the refusal for an error of the parser. `rest` begins with the rejected line.
HeadRefusal make_refusal(http::error error, std::string_view head, std::string_view rest) {
  switch (error) {
    case http::error::bad_version:
      if (has_http_version(head)) return {505, "only HTTP/1.1 is supported"};
      return {400, "the request line is not METHOD TARGET VERSION"};
    case http::error::bad_method:
    case http::error::bad_target: return {400, "the request line is not METHOD TARGET VERSION"};
    case http::error::bad_content_length:
      if (is_oversized_length(rest)) return {413, "the body is too long"};
      return {400, "Content-Length is not a number"};
    case http::error::bad_transfer_encoding:
      return {501, "Transfer-Encoding: header not supported; send Content-Length"};
    case http::error::body_limit: return {413, "the body is too long"};
    case http::error::header_limit: return {431, "the head is too long"};
    case http::error::bad_value: return {400, "the value of a header is malformed"};
    case http::error::need_more:
    case http::error::bad_line_ending: return {400, "a line does not end with CR LF"};
    default: return {400, "a header is not NAME: VALUE"};
  }
}

}  // namespace

std::string to_lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return lower;
}

std::optional<std::string> percent_decode(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (text.size() - i < 3) return std::nullopt;
    const int high = hex_digit_value(text[i + 1]), low = hex_digit_value(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  const bool has_control =
      std::ranges::any_of(decoded, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7F; });
  if (has_control || !is_utf8(decoded)) return std::nullopt;
  return decoded;
}

std::string percent_encode(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF", kMarks = "-._~";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_unreserved = byte < 0x80 && (std::isalnum(byte) != 0 || kMarks.find(c) != std::string_view::npos);
    if (is_unreserved)
      encoded += c;
    else
      encoded.append({'%', kDigits[byte / 16], kDigits[byte % 16]});
  }
  return encoded;
}

std::optional<std::size_t> find_head_end(std::string_view bytes) {
  const auto strict = bytes.find("\n\r\n"), loose = bytes.find("\n\n");
  if (strict == std::string_view::npos && loose == std::string_view::npos) return std::nullopt;
  return loose < strict ? loose + 2 : strict + 3;
}

std::variant<RequestHead, HeadRefusal> read_head(std::string_view head) {
  if (head.size() > kMaxHeadBytes) return HeadRefusal{431, "the head is too long"};
  // Beast joins the lines of a folded header, but a proxy in front of the monitor may not.
  if (head.find("\n ") != std::string_view::npos || head.find("\n\t") != std::string_view::npos)
    return HeadRefusal{400, "a header is folded"};
  http::request_parser<http::empty_body> parser;
  parser.header_limit(kMaxHeadBytes);
  parser.body_limit(kMaxBodyBytes);
  boost::beast::error_code error;
  const auto parsed_bytes = parser.put(const_buffer(head.data(), head.size()), error);
  const auto& message = parser.get();
  if (error && message.find(http::field::transfer_encoding) != message.end())
    error = http::error::bad_transfer_encoding;
  if (error) return make_refusal(static_cast<http::error>(error.value()), head, head.substr(parsed_bytes));
  if (!parser.is_header_done() || parsed_bytes != head.size())
    return HeadRefusal{400, "a line does not end with CR LF"};
  if (message.method() != http::verb::get && message.method() != http::verb::post)
    return HeadRefusal{405, "only GET and POST are supported"};
  RequestHead request;
  request.method = to_view(message.method_string());
  request.accepts_chunks = message.version() == 11;
  request.keep_alive = request.accepts_chunks && parser.keep_alive();
  if (const auto refusal = read_target(to_view(message.target()), request)) return *refusal;
  for (const auto& field : message)
    if (const auto refusal = read_header(to_view(field.name_string()), to_view(field.value()), request))
      return *refusal;
  if (const auto refusal = read_body_size(request)) return *refusal;
  return request;
}

bool is_chunked(const WebAnswer& answer, const RequestHead& request) {
  return answer.stream && answer.stream_size == 0 && request.accepts_chunks;
}

std::string answer_head(const WebAnswer& answer, const RequestHead& request) {
  http::response<http::empty_body> message;
  message.result(static_cast<unsigned>(answer.status));
  message.set(http::field::content_type, answer.type);
  if (is_chunked(answer, request))
    message.chunked(true);
  else if (!answer.stream || answer.stream_size > 0)
    message.content_length(answer.stream ? answer.stream_size : answer.body.size());
  if (request.keep_alive)
    message.set("Keep-Alive", fmt::format("timeout={}, max={}", kIdleTimeout.count(), kMaxRequests));
  else
    message.set(http::field::connection, "close");
  for (const auto& [name, value] : answer.headers) message.insert(name, value);
  for (const auto& [name, value] : kCommonHeaders)
    if (message.find(name) == message.end()) message.insert(name, value);
  http::response_serializer<http::empty_body> serializer(message);
  boost::beast::error_code error;
  std::string text;
  serializer.next(error, [&](auto&, const auto& buffers) { text = boost::beast::buffers_to_string(buffers); });
  return text;
}

std::string encode_chunk(std::string_view piece) {
  if (piece.empty()) return boost::beast::buffers_to_string(http::make_chunk_last());
  return boost::beast::buffers_to_string(http::make_chunk(const_buffer(piece.data(), piece.size())));
}

std::string find_cookie(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const auto end = std::min(header.find(';'), header.size());
    const auto cookie = trimmed(header.substr(0, end));
    header.remove_prefix(std::min(end + 1, header.size()));
    const auto equals = cookie.find('=');
    if (equals != std::string_view::npos && cookie.substr(0, equals) == name)
      return std::string(cookie.substr(equals + 1));
  }
  return {};
}

}  // namespace gyrotherm::monitor
