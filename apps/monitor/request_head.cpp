// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/request_head.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

/// A character of a token, as names of methods and headers are made of (RFC 9110, 5.6.2).
bool is_token(char c) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
         kMarks.find(c) != std::string_view::npos;
}

bool is_printable(char c) { return c > ' ' && c < 0x7F; }

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The text up to the next CR LF, which is taken away too.
std::optional<std::string_view> take_line(std::string_view& rest) {
  const auto end = rest.find('\n');
  if (end == std::string_view::npos || end == 0 || rest[end - 1] != '\r') return std::nullopt;
  const auto line = rest.substr(0, end - 1);
  rest.remove_prefix(end + 1);
  return line;
}

using Trouble = std::optional<HeadRefusal>;

Trouble read_query(std::string_view text, RequestHead& head) {
  while (!text.empty()) {
    const auto end = std::min(text.find('&'), text.size());
    const auto pair = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto equals = std::min(pair.find('='), pair.size());
    const auto name = percent_decoded(pair.substr(0, equals));
    const auto value = percent_decoded(pair.substr(std::min(equals + 1, pair.size())));
    if (!name || !value) return HeadRefusal{400, "the query is not well encoded"};
    if (!head.query.emplace(*name, *value).second) return HeadRefusal{400, "a parameter stands twice"};
  }
  return std::nullopt;
}

/// Whether a part of the path would lead elsewhere than it says.
bool leads_elsewhere(std::string_view path) {
  while (!path.empty()) {
    path.remove_prefix(1);
    const auto end = std::min(path.find('/'), path.size());
    const auto part = path.substr(0, end);
    if (part == "." || part == ".." || part.find('\\') != std::string_view::npos) return true;
    path.remove_prefix(end);
  }
  return false;
}

Trouble read_target(std::string_view target, RequestHead& head) {
  if (target.size() > kLongestTarget) return HeadRefusal{414, "the address is too long"};
  if (!target.starts_with('/') || target.starts_with("//")) return HeadRefusal{400, "the address is no path"};
  if (!std::ranges::all_of(target, is_printable)) return HeadRefusal{400, "the address has characters of no address"};
  if (target.find('#') != std::string_view::npos) return HeadRefusal{400, "the address has a fragment"};
  const auto question = std::min(target.find('?'), target.size());
  const auto raw = target.substr(0, question);
  const auto path = percent_decoded(raw);
  const bool hides_slash =
      std::count(raw.begin(), raw.end(), '/') != (path ? std::count(path->begin(), path->end(), '/') : -1);
  if (!path || hides_slash || leads_elsewhere(*path)) return HeadRefusal{400, "the path is none of this page's"};
  head.path = *path;
  return read_query(target.substr(std::min(question + 1, target.size())), head);
}

Trouble read_request_line(std::string_view line, RequestHead& head) {
  const auto first = line.find(' ');
  const auto second = first == std::string_view::npos ? first : line.find(' ', first + 1);
  if (second == std::string_view::npos || line.find(' ', second + 1) != std::string_view::npos)
    return HeadRefusal{400, "the request line is not METHOD PATH VERSION"};
  const auto method = line.substr(0, first), version = line.substr(second + 1);
  if (method.empty() || !std::ranges::all_of(method, is_token)) return HeadRefusal{400, "the method is no word"};
  if (!version.starts_with("HTTP/")) return HeadRefusal{400, "the version is none of HTTP"};
  if (version != "HTTP/1.1" && version != "HTTP/1.0") return HeadRefusal{505, "only HTTP/1.1 is spoken here"};
  if (method != "GET" && method != "POST") return HeadRefusal{405, "only GET and POST are known here"};
  head.method = method;
  head.keep_alive = head.takes_chunks = version == "HTTP/1.1";
  return read_target(line.substr(first + 1, second - first - 1), head);
}

Trouble read_header(std::string_view line, RequestHead& head) {
  const auto colon = line.find(':');
  if (colon == 0 || colon == std::string_view::npos || !std::ranges::all_of(line.substr(0, colon), is_token))
    return HeadRefusal{400, "a header is not NAME: VALUE"};
  const auto name = in_small_letters(line.substr(0, colon));
  const auto value = trimmed(line.substr(colon + 1));
  if (!std::ranges::all_of(value,
                           [](char c) { return c == '\t' || (static_cast<unsigned char>(c) >= ' ' && c != 0x7F); }))
    return HeadRefusal{400, "a header has control characters"};
  if (head.headers.size() >= kMostHeaders) return HeadRefusal{431, "there are too many headers"};
  const auto [found, is_new] = head.headers.emplace(name, value);
  if (is_new) return std::nullopt;
  constexpr std::array kLists{"accept", "accept-encoding", "accept-language", "cache-control",
                              "via",    "x-forwarded-for"};
  if (std::ranges::find(kLists, name) == kLists.end())
    return HeadRefusal{400, "a header stands twice that may stand once"};
  found->second.append(", ").append(value);  // several lines of a list are one (RFC 9110, 5.3)
  return std::nullopt;
}

Trouble read_body_size(RequestHead& head) {
  if (head.headers.contains("transfer-encoding")) return HeadRefusal{501, "a body comes with its length here"};
  if (head.headers.contains("expect")) return HeadRefusal{501, "nothing is expected here"};
  if (head.headers.contains("upgrade")) return HeadRefusal{501, "nothing else than HTTP/1.1 is spoken here"};
  const auto length = head.headers.find("content-length");
  if (length == head.headers.end())
    return head.method == "POST" ? Trouble(HeadRefusal{411, "a POST says how long it is"}) : std::nullopt;
  const auto& text = length->second;
  if (text.empty() || !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; }))
    return HeadRefusal{400, "the length is no number"};
  constexpr std::size_t kLongestNumber = 9;
  if (text.size() > kLongestNumber) return HeadRefusal{413, "the body is too long"};
  std::from_chars(text.data(), text.data() + text.size(), head.body_size);
  if (head.method == "GET" && head.body_size > 0) return HeadRefusal{400, "a GET has no body here"};
  return head.body_size > kLargestBody ? Trouble(HeadRefusal{413, "the body is too long"}) : std::nullopt;
}

}  // namespace

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return small;
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (text.size() - i < 3) return std::nullopt;
    const int high = digit_of(text[i + 1]), low = digit_of(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  const bool steers =
      std::ranges::any_of(decoded, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7F; });
  if (steers || !is_utf8(decoded)) return std::nullopt;
  return decoded;
}

std::string percent_encoded(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF", kMarks = "-._~";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 0x80 && (std::isalnum(byte) != 0 || kMarks.find(c) != std::string_view::npos);
    if (plain)
      encoded += c;
    else
      encoded.append({'%', kDigits[byte / 16], kDigits[byte % 16]});
  }
  return encoded;
}

std::optional<std::size_t> end_of_head(std::string_view bytes) {
  const auto strict = bytes.find("\n\r\n"), loose = bytes.find("\n\n");
  if (strict == std::string_view::npos && loose == std::string_view::npos) return std::nullopt;
  return loose < strict ? loose + 2 : strict + 3;
}

std::variant<RequestHead, HeadRefusal> read_head(std::string_view bytes) {
  if (bytes.size() > kLongestHead) return HeadRefusal{431, "the head is too long"};
  RequestHead head;
  auto line = take_line(bytes);
  if (!line) return HeadRefusal{400, "a line does not end with CR LF"};
  if (const auto trouble = read_request_line(*line, head)) return *trouble;
  while ((line = take_line(bytes)) && !line->empty())
    if (const auto trouble = read_header(*line, head)) return *trouble;
  if (!line || !bytes.empty()) return HeadRefusal{400, "a line does not end with CR LF"};
  if (const auto trouble = read_body_size(head)) return *trouble;
  if (in_small_letters(head.header("connection")).find("close") != std::string::npos) head.keep_alive = false;
  return head;
}

std::string cookie_in(std::string_view header, std::string_view name) {
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
