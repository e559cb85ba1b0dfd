// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/request_head.hpp"

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

/// As of a proxy that adds a line of its own behind that of the proxy before it.
TEST(RequestHead, TakesTheLinesOfAListForOne) {
  const auto read =
      read_head(head_with("GET / HTTP/1.1", "X-Forwarded-For: 192.0.2.7\r\nX-Forwarded-For: 198.51.100.3\r\n"));
  ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
  EXPECT_EQ(std::get<RequestHead>(read).header("x-forwarded-for"), "192.0.2.7, 198.51.100.3");
}

TEST(RequestHead, SaysHowLongABodyIs) {
  const auto read = read_head(head_with("POST /x HTTP/1.1", "Content-Length: 12\r\nConnection: close\r\n"));
  ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
  EXPECT_EQ(std::get<RequestHead>(read).body_size, 12u);
  EXPECT_FALSE(std::get<RequestHead>(read).keep_alive);
}

TEST(RequestHead, EndsTheConnectionInAnyLetters) {
  for (const auto* word : {"close", "Close", "CLOSE", "TE, Close"}) {
    const auto read = read_head(head_with("GET / HTTP/1.1", std::string("Connection: ") + word + "\r\n"));
    ASSERT_TRUE(std::holds_alternative<RequestHead>(read));
    EXPECT_FALSE(std::get<RequestHead>(read).keep_alive) << word;
  }
}

TEST(RequestHead, IsRefusedWhereTwoReadersCouldDiffer) {
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 1\r\nContent-Length: 1\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("POST / HTTP/1.1", "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n")), 501);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X : y\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("GET / HTTP/1.1", "X: y\r\n z\r\n")), 400);
  EXPECT_EQ(refused_with(head_with("GET /a/%2e%2e/b HTTP/1.1")), 400);
  EXPECT_EQ(refused_with(head_with("GET /a%2fb HTTP/1.1")), 400);
  EXPECT_EQ(refused_with("GET / HTTP/1.1\nHost: page\n\n"), 400);
}

TEST(RequestHead, EndsAtItsFirstEmptyLine) {
  EXPECT_EQ(end_of_head("GET / HTTP/1.1\r\nHost: a\r\n"), std::nullopt);
  EXPECT_EQ(end_of_head("a\r\n\r\nb"), 5u);
  EXPECT_EQ(end_of_head("a\n\nb\r\n\r\n"), 3u);
  EXPECT_EQ(end_of_head("a\n\r\nb"), 4u);
}

TEST(RequestHead, CookiesAreFoundByTheirWholeName) {
  EXPECT_EQ(cookie_in("a=1; session=two; b=3", "session"), "two");
  EXPECT_EQ(cookie_in("xsession=1", "session"), "");
  EXPECT_EQ(cookie_in("", "session"), "");
}

}  // namespace
}  // namespace gyrotherm::monitor
