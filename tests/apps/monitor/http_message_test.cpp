// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/http_message.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::monitor {
namespace {

std::string head_with(const std::string& line, const std::string& headers = "") {
  return line + "\r\nHost: page\r\n" + headers + "\r\n";
}

int refused_with(const std::string& head) {
  const auto read = read_head(head);
  const auto* why = std::get_if<HeadRefusal>(&read);
  return why == nullptr ? 0 : why->status;
}

TEST(RequestHead, HasPathQueryAndHeaders) {
  const auto read = read_head(head_with("GET /api/v1/runs/ab/series?channels=u1.x.rate,A%20B&from=10 HTTP/1.1",
                                        "Accept: a\r\nAccept: b\r\nX-CSRF-Token:  s \r\n"));
  ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
  const auto& head = std::get<RequestHead>(read);
  EXPECT_EQ(head.method, "GET");
  EXPECT_EQ(head.path, "/api/v1/runs/ab/series");
  EXPECT_EQ(head.parameter("channels"), "u1.x.rate,A B");
  EXPECT_EQ(head.parameter("from"), "10");
  EXPECT_EQ(head.header("host"), "page");
  EXPECT_EQ(head.header("x-csrf-token"), "s");
  EXPECT_TRUE(head.keep_alive);
}

/// A proxy appends a line of its own after the line of the previous proxy.
TEST(RequestHead, JoinsLinesOfAList) {
  const auto read =
      read_head(head_with("GET / HTTP/1.1", "X-Forwarded-For: 192.0.2.7\r\nX-Forwarded-For: 198.51.100.3\r\n"));
  ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
  EXPECT_EQ(std::get<RequestHead>(read).header("x-forwarded-for"), "192.0.2.7, 198.51.100.3");
}

TEST(RequestHead, HasSizeOfBody) {
  const auto read = read_head(head_with("POST /x HTTP/1.1", "Content-Length: 12\r\nConnection: close\r\n"));
  ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
  EXPECT_EQ(std::get<RequestHead>(read).body_size, 12u);
  EXPECT_FALSE(std::get<RequestHead>(read).keep_alive);
}

TEST(RequestHead, ReadsConnectionCloseInAnyCase) {
  for (const auto* word : {"close", "Close", "CLOSE", "TE, Close"}) {
    const auto read = read_head(head_with("GET / HTTP/1.1", std::string("Connection: ") + word + "\r\n"));
    ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
    EXPECT_FALSE(std::get<RequestHead>(read).keep_alive) << word;
  }
}

TEST(RequestHead, IsRefusedWhenAmbiguous) {
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 1\r\nContent-Length: 1\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n")), 501);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Transfer-Encoding:\tchunked\r\nContent-Length: 1\r\n")), 501);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X : y\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X: y\r\n z\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("GET /a/%2e%2e/b HTTP/1.1")), 400);
  EXPECT_EQ(refused_with(head_with("GET /a%2fb HTTP/1.1")), 400);
  EXPECT_EQ(refused_with("GET / HTTP/1.1\nHost: page\n\n"), 400);
}

/// Beast alone would join the lines of a folded header, accept a list of equal lengths, and wrap a length of 2^64.
TEST(RequestHead, IsRefusedWhenBeastWouldAcceptIt) {
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X:\r\n y\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X: y\r\n\tz\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 2, 2\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 18446744073709551618\r\n")), 413);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 4097\r\n")), 413);
  EXPECT_EQ(refused_with(head_with("GET /\xC3\xA9 HTTP/1.1")), 400);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1") + "x"), 400);
}

TEST(RequestHead, IsRefusedForOtherVersions) {
  EXPECT_EQ(refused_with(head_with("GET / HTTP/2.0")), 505);
  EXPECT_EQ(refused_with(head_with("GET / FTP/1.1")), 400);
  EXPECT_EQ(refused_with(head_with("GET / a HTTP/1.1")), 400);
  EXPECT_EQ(refused_with("GET / HTTP/1.1\n\n"), 400);
}

TEST(AnswerHead, HasSizeOrChunkedEncoding) {
  const RequestHead modern{.method = "GET",
                           .path = "/",
                           .query = {},
                           .headers = {},
                           .body_size = 0,
                           .keep_alive = true,
                           .accepts_chunks = true};
  const auto sized = answer_head({.body = "{}", .headers = {{"Cache-Control", "private"}}}, modern);
  EXPECT_TRUE(sized.starts_with("HTTP/1.1 200 OK\r\n")) << sized;
  EXPECT_TRUE(sized.ends_with("\r\n\r\n")) << sized;
  EXPECT_NE(sized.find("\r\nContent-Length: 2\r\n"), std::string::npos) << sized;
  EXPECT_NE(sized.find("\r\nCache-Control: private\r\n"), std::string::npos) << sized;
  EXPECT_EQ(sized.find("no-store"), std::string::npos) << sized;
  WebAnswer stream;
  stream.stream = [](const Send&) { return true; };
  const auto chunked = answer_head(stream, modern);
  EXPECT_NE(chunked.find("\r\nTransfer-Encoding: chunked\r\n"), std::string::npos) << chunked;
  EXPECT_EQ(chunked.find("Content-Length"), std::string::npos) << chunked;
  const auto until_end = answer_head(stream, {});
  EXPECT_NE(until_end.find("\r\nConnection: close\r\n"), std::string::npos) << until_end;
  EXPECT_EQ(until_end.find("Transfer-Encoding"), std::string::npos) << until_end;
}

TEST(Chunk, HasItsSizeAndLastIsEmpty) {
  EXPECT_EQ(encode_chunk("eleven byte"), "b\r\neleven byte\r\n");
  EXPECT_EQ(encode_chunk(""), "0\r\n\r\n");
}

TEST(RequestHead, EndsAtItsFirstEmptyLine) {
  EXPECT_EQ(find_head_end("GET / HTTP/1.1\r\nHost: a\r\n"), std::nullopt);
  EXPECT_EQ(find_head_end("a\r\n\r\nb"), 5u);
  EXPECT_EQ(find_head_end("a\n\nb\r\n\r\n"), 3u);
  EXPECT_EQ(find_head_end("a\n\r\nb"), 4u);
}

TEST(RequestHead, FindsCookiesByWholeName) {
  EXPECT_EQ(find_cookie("a=1; session=two; b=3", "session"), "two");
  EXPECT_EQ(find_cookie("xsession=1", "session"), "");
  EXPECT_EQ(find_cookie("", "session"), "");
}

}  // namespace
}  // namespace gyrotherm::monitor
