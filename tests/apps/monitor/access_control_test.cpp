// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/access_control.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "apps/monitor/http_message.hpp"
#include "core/json.hpp"
#include "tests/apps/monitor/blocked_file.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr const char *kPassword = "a long password", *kOther = "another password";

class Access : public ::testing::Test {
 protected:
  void put(const std::string& name, Role role, const std::string& password) {
    change([&](UserList& list) { return add_or_replace_user(list, name, role, password); });
  }
  void remove(const std::string& name) {
    change([&](UserList& list) { return remove_user_or_token(list, name); });
  }
  template <class Change>
  void change(Change change) {
    auto list = read_users(folder_ / "users.json");
    ASSERT_TRUE(list && change(*list) && write_users(folder_ / "users.json", *list));
  }
  static WebRequest request(const std::string& path, const std::string& peer = "127.0.0.1") {
    WebRequest request;
    request.head.method = "GET";
    request.head.path = path;
    request.peer = peer;
    request.head.headers = {{"host", "page"}, {"origin", "http://page"}, {"content-type", "application/json"}};
    return request;
  }
  WebAnswer log_in(const std::string& name, const std::string& password, const std::string& peer = "127.0.0.1") {
    auto sent = request("/api/v1/login", peer);
    sent.head.method = "POST";
    sent.body = fmt::format(R"({{"name":"{}","password":"{}"}})", name, password);
    return access_.log_in(sent);
  }
  /// Logs in and returns the cookie of the answer.
  std::string cookie_of(const std::string& name, const std::string& password) {
    const auto answer = log_in(name, password);
    EXPECT_EQ(answer.status, 200);
    const auto& header = answer.headers.front().second;
    return header.substr(0, header.find(';'));
  }
  /// Returns a POST that the page sends in the session of a cookie.
  WebRequest page_post(const std::string& path, const std::string& cookie, const std::string& body = "{}") {
    auto sent = request(path);
    sent.head.headers["cookie"] = cookie;
    const auto csrf = Json::parse(access_.answer_session(sent).body)["csrf"];
    if (csrf.is_string()) sent.head.headers["x-csrf-token"] = csrf.get<std::string>();
    sent.head.method = "POST";
    sent.body = body;
    return sent;
  }
  /// Returns the name of the user that a cookie identifies, or an empty text.
  static std::string user_admitted_by(AccessControl& access, const std::string& cookie) {
    auto sent = request("/api/v1/runs");
    sent.head.headers["cookie"] = cookie;
    const auto found = access.identify_sender(sent);
    const auto* sender = std::get_if<Sender>(&found);
    return sender == nullptr ? "" : sender->name();
  }

  tests::TestFolder folder_;
  VirtualClock clock_;
  Users users_{folder_ / "users.json"};
  Sessions sessions_{folder_ / "sessions.json", clock_};
  AccessControl access_{{.control = true, .allows_guests = false}, users_, sessions_, clock_};
};

TEST_F(Access, DoesNotReviveSessionsOfReaddedUser) {
  put("eve", Role::viewer, kPassword);
  const auto cookie = cookie_of("eve", kPassword);
  EXPECT_EQ(user_admitted_by(access_, cookie), "eve");
  remove("eve");
  EXPECT_EQ(user_admitted_by(access_, cookie), "");
  put("eve", Role::administrator, kPassword);
  EXPECT_EQ(user_admitted_by(access_, cookie), "");
  EXPECT_EQ(user_admitted_by(access_, cookie_of("eve", kPassword)), "eve");
}

TEST_F(Access, EndsSessionsOfOldPasswordAfterRestart) {
  put("ada", Role::conductor, kPassword);
  const auto cookie = cookie_of("ada", kPassword), kept = cookie_of("ada", kPassword);
  put("ada", Role::conductor, kOther);
  EXPECT_EQ(user_admitted_by(access_, cookie), "");
  Sessions read(folder_ / "sessions.json", clock_);
  ASSERT_TRUE(read.load());
  AccessControl again({.control = true, .allows_guests = false}, users_, read, clock_);
  EXPECT_EQ(user_admitted_by(again, kept), "");
  EXPECT_EQ(user_admitted_by(again, cookie), "");
}

TEST_F(Access, ReportsLogoutThatCannotBeStored) {
  put("ada", Role::viewer, kPassword);
  const auto cookie = cookie_of("ada", kPassword);
  const auto logout = page_post("/api/v1/logout", cookie);
  {
    const BlockedFile blocked(folder_ / "sessions.json");
    const auto answer = access_.log_out(logout);
    EXPECT_EQ(answer.status, 500);
    EXPECT_FALSE(Json::parse(answer.body)["error"].get<std::string>().empty());
    ASSERT_EQ(answer.headers.size(), 1u);
    EXPECT_NE(answer.headers.front().second.find("Max-Age=0"), std::string::npos) << "the browser forgets the secret";
    EXPECT_EQ(user_admitted_by(access_, cookie), "");
    EXPECT_EQ(access_.log_out(logout).status, 500) << "repeated";
  }
  EXPECT_EQ(access_.log_out(logout).status, 200);
  Sessions read(folder_ / "sessions.json", clock_);
  ASSERT_TRUE(read.load());
  EXPECT_TRUE(read.all().empty());
}

TEST_F(Access, ReportsEndOfSessionsThatCannotBeStored) {
  put("ada", Role::administrator, kPassword);
  put("eve", Role::viewer, kPassword);
  const auto cookie = cookie_of("eve", kPassword);
  const auto end = page_post("/api/v1/sessions", cookie_of("ada", kPassword), R"({"user":"eve"})");
  {
    const BlockedFile blocked(folder_ / "sessions.json");
    EXPECT_EQ(access_.answer_sessions(end).status, 500);
    EXPECT_EQ(user_admitted_by(access_, cookie), "");
  }
  EXPECT_EQ(access_.answer_sessions(end).status, 200);
  Sessions read(folder_ / "sessions.json", clock_);
  ASSERT_TRUE(read.load());
  EXPECT_EQ(read.all().size(), 1u);
}

TEST_F(Access, RefusesForgedRequestsOfEveryKind) {
  put("ada", Role::administrator, kPassword);
  const auto cookie = cookie_of("ada", kPassword);
  const auto whole = page_post("/api/v1/sessions", cookie, R"({"user":"eve"})");
  auto unnamed = whole, without_secret = whole, wrong_secret = whole, by_fetch = whole;
  for (auto* sent : {&unnamed, &by_fetch}) sent->head.headers.erase("origin");
  by_fetch.head.headers["sec-fetch-site"] = "same-origin";
  without_secret.head.headers.erase("x-csrf-token");
  wrong_secret.head.headers["x-csrf-token"].back() ^= 1;
  const auto change_status = [&](const WebRequest& sent) {
    const auto found = access_.identify_sender(sent);
    const auto refused = access_.change_refusal(std::get<Sender>(found), sent, Role::conductor);
    return refused ? refused->status : 200;
  };
  for (const auto* sent : {&unnamed, &without_secret, &wrong_secret}) {
    EXPECT_EQ(change_status(*sent), 403);
    EXPECT_EQ(access_.answer_sessions(*sent).status, 403);
    EXPECT_EQ(access_.log_out(*sent).status, 403);
  }
  for (const auto& sent : {whole, by_fetch}) {
    EXPECT_EQ(change_status(sent), 200);
    EXPECT_EQ(access_.answer_sessions(sent).status, 200);
  }
  EXPECT_EQ(access_.log_out(by_fetch).status, 200);
  EXPECT_EQ(user_admitted_by(access_, cookie), "");
}

TEST_F(Access, RequiresNoOriginOfScripts) {
  std::string secret;
  change([&](UserList& list) {
    return add_or_replace_token(list, "script", Role::administrator).map([&](const std::string& made) {
      secret = made;
    });
  });
  auto sent = request("/api/v1/sessions");
  sent.head.method = "POST";
  sent.head.headers.erase("origin");
  sent.head.headers["authorization"] = "Bearer " + secret;
  sent.body = R"({"user":"eve"})";
  EXPECT_EQ(access_.answer_sessions(sent).status, 200);
}

TEST_F(Access, RefusesBodyWithDuplicateKey) {
  put("ada", Role::viewer, kPassword);
  auto sent = request("/api/v1/login");
  sent.head.method = "POST";
  sent.body = fmt::format(R"({{"name":"eve","name":"ada","password":"{}"}})", kPassword);
  EXPECT_EQ(access_.log_in(sent).status, 400);
  EXPECT_EQ(log_in("ada", kPassword).status, 200);
}

TEST_F(Access, AdmitsUserWhileOthersGuessItsPassword) {
  put("ada", Role::conductor, kPassword);
  int refused = 0;
  for (int i = 0; i < 12; ++i) refused += log_in("ada", "", "10.0.0.1").status == 429 ? 1 : 0;
  EXPECT_EQ(refused, 2);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(log_in("ada", "", fmt::format("10.0.1.{}", i)).status, 401);
  EXPECT_EQ(log_in("ada", kPassword, "10.0.2.1").status, 200);
  int tried = 0;
  // Rejected without hashing.
  const std::string too_long(kMaxPasswordBytes + 1, 'x');
  for (int i = 0; i < 600; ++i)
    tried += log_in("eve", too_long, fmt::format("10.1.{}.{}", i / 200, i % 200)).status == 401;
  EXPECT_EQ(tried, 500) << "and a name is not guessed at from everywhere without end";
}

TEST_F(Access, LimitsLoginsFromOneIpv6Network) {
  put("ada", Role::conductor, kPassword);
  // Rejected without hashing.
  const std::string too_long(kMaxPasswordBytes + 1, 'x');
  int tried = 0;
  for (int i = 0; i < 100; ++i) tried += log_in("eve", too_long, fmt::format("2001:db8::{:x}", i)).status == 401;
  EXPECT_EQ(tried, 10);
  EXPECT_EQ(log_in("ada", kPassword, "2001:db8::ffff").status, 429);
  EXPECT_EQ(log_in("ada", kPassword, "2001:db8:0:1::1").status, 200);
}

TEST_F(Access, AdmitsNewAddressesWhenManyAreKnown) {
  put("ada", Role::conductor, kPassword);
  const std::string too_long(kMaxPasswordBytes + 1, 'x');
  for (std::size_t i = 0; i <= RateLimit::kMaxNames; ++i) {
    const auto peer = fmt::format("2001:db8:1:{:x}::1", i);
    ASSERT_FALSE(access_.general_refusal(request("/", peer)));
    ASSERT_EQ(log_in(fmt::format("eve{}", i), too_long, peer).status, 401);
    auto sent = request("/api/v1/runs", peer);
    sent.head.headers["authorization"] = "Bearer none";
    const auto found = access_.identify_sender(sent);
    ASSERT_EQ(std::get<WebAnswer>(found).status, 401);
  }
  EXPECT_FALSE(access_.general_refusal(request("/", "10.0.0.1")));
  EXPECT_EQ(log_in("ada", kPassword, "10.0.0.1").status, 200);
}

TEST_F(Access, KeepsCookiesOfTwoMonitorsOnOneHost) {
  put("ada", Role::viewer, kPassword);
  Sessions others(folder_ / "others.json", clock_);
  AccessControl other({.control = true, .allows_guests = false}, users_, others, clock_);
  // Keeps cookies by host name without the port, as a browser does.
  std::map<std::string, std::string> kept;
  const auto calls = [&](AccessControl& access, const std::string& host, const std::string& path) {
    auto sent = request(path);
    sent.head.headers["host"] = host;
    sent.head.headers["origin"] = "http://" + host;
    for (const auto& [name, secret] : kept) sent.head.headers["cookie"] += name + "=" + secret + "; ";
    sent.body = fmt::format(R"({{"name":"ada","password":"{}"}})", kPassword);
    if (path == "/") return std::holds_alternative<Sender>(access.identify_sender(sent));
    sent.head.method = "POST";
    const auto answer = access.log_in(sent);
    for (const auto& [header, value] : answer.headers)
      if (header == "Set-Cookie") {
        const auto equals = value.find('=');
        kept[value.substr(0, equals)] = value.substr(equals + 1, value.find(';') - equals - 1);
      }
    return true;
  };
  calls(access_, "localhost:8321", "/api/v1/login");
  calls(other, "localhost:8322", "/api/v1/login");
  EXPECT_TRUE(calls(access_, "localhost:8321", "/"));
  EXPECT_TRUE(calls(other, "localhost:8322", "/"));
  EXPECT_FALSE(calls(other, "[::1]", "/")) << "no port is in there";
  calls(other, "[::1]", "/api/v1/login");
  EXPECT_TRUE(calls(other, "rig.example.org", "/"));
  EXPECT_TRUE(calls(access_, "localhost:8321", "/"));
}

TEST_F(Access, ComparesHostsWithoutCase) {
  auto sent = request("/");
  sent.head.headers["host"] = "RIG.example.org:8321";
  sent.head.headers["origin"] = "http://rig.example.org:8321";
  EXPECT_FALSE(access_.general_refusal(sent));
  sent.head.headers["origin"] = "http://pig.example.org:8321";
  EXPECT_TRUE(access_.general_refusal(sent));
}

}  // namespace
}  // namespace gyrotherm::monitor
