// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/users.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "apps/monitor/sessions.hpp"
#include "core/file.hpp"
#include "tests/apps/monitor/blocked_file.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""h;
using std::chrono_literals::operator""min;
using std::chrono_literals::operator""s;

struct Site {
  tests::TestFolder folder;
  std::string file = folder / "users.json";
};

void put(const std::string& file, const std::string& name, Role role) {
  auto list = read_users(file);
  ASSERT_TRUE(list) << text(list.error());
  ASSERT_TRUE(add_or_replace_user(*list, name, role, "a long password"));
  ASSERT_TRUE(write_users(file, *list));
}

TEST(Users, AreIdentifiedOnlyByPassword) {
  const Site site;
  put(site.file, "ada", Role::conductor);
  Users users(site.file);
  ASSERT_TRUE(users.load());
  const auto ada = users.find_by_password("ada", "a long password");
  ASSERT_TRUE(ada);
  EXPECT_EQ(ada->role, Role::conductor);
  EXPECT_FALSE(users.find_by_password("ada", "a long passwore"));
  EXPECT_FALSE(users.find_by_password("eve", "a long password"));
  EXPECT_FALSE(users.find_by_password("ada", ""));
}

TEST(Users, AreStoredInPrivateFileWithoutSecrets) {
  const Site site;
  put(site.file, "ada", Role::viewer);
  auto list = read_users(site.file);
  ASSERT_TRUE(list);
  const auto secret = add_or_replace_token(*list, "script", Role::viewer);
  ASSERT_TRUE(secret && write_users(site.file, *list));
  const auto stored = read_text_file(site.file);
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->find("a long password"), std::string::npos);
  EXPECT_EQ(stored->find(*secret), std::string::npos);
  EXPECT_NE(stored->find("$argon2id$"), std::string::npos);
  struct stat facts {};
  ASSERT_EQ(::stat(site.file.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600u);
  ::chmod(site.file.c_str(), 0640);
  EXPECT_FALSE(read_users(site.file)) << "a file that others read lets nobody in";
  Users users(site.file);
  EXPECT_FALSE(users.find_by_name("ada"));
  EXPECT_TRUE(users.has_any()) << "and does not open the door";
}

TEST(Users, AreRejectedAtOnceWhenRemoved) {
  const Site site;
  put(site.file, "ada", Role::viewer);
  Users users(site.file);
  ASSERT_TRUE(users.find_by_name("ada"));
  auto list = read_users(site.file);
  ASSERT_TRUE(list && remove_user_or_token(*list, "ada") && write_users(site.file, *list));
  EXPECT_FALSE(users.find_by_name("ada"));
  EXPECT_FALSE(users.has_any());
  EXPECT_FALSE(remove_user_or_token(*list, "ada"));
}

TEST(Users, RefuseInvalidNamesAndPasswords) {
  UserList list;
  EXPECT_FALSE(add_or_replace_user(list, "", Role::viewer, "a long password"));
  EXPECT_FALSE(add_or_replace_user(list, "a b", Role::viewer, "a long password"));
  EXPECT_FALSE(add_or_replace_user(list, "ada\n", Role::viewer, "a long password"));
  EXPECT_FALSE(add_or_replace_user(list, "ada", Role::viewer, "short"));
  ASSERT_TRUE(add_or_replace_token(list, "ada", Role::viewer));
  EXPECT_FALSE(add_or_replace_user(list, "ada", Role::viewer, "a long password")) << "the name of a token";
}

TEST(Users, RequireWholeToken) {
  const Site site;
  UserList list;
  const auto secret = add_or_replace_token(list, "script", Role::viewer);
  ASSERT_TRUE(secret && write_users(site.file, list));
  EXPECT_EQ(secret->size(), 43u);
  Users users(site.file);
  EXPECT_TRUE(users.find_by_token(*secret));
  EXPECT_FALSE(users.find_by_token(secret->substr(1)));
  EXPECT_FALSE(users.find_by_token(*secret + "A"));
  EXPECT_FALSE(users.find_by_token(""));
}

TEST(Sessions, SurviveRestartAndExpireUnused) {
  const Site site;
  VirtualClock clock;
  const auto file = site.folder / "sessions.json";
  std::string secret;
  {
    Sessions sessions(file, clock);
    secret = sessions.open("ada", "a password");
    EXPECT_TRUE(sessions.find(secret));
  }
  Sessions sessions(file, clock);
  ASSERT_TRUE(sessions.load());
  const auto found = sessions.find(secret);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->user, "ada");
  EXPECT_EQ(found->password_id, "a password");
  EXPECT_EQ(read_text_file(file)->find(secret), std::string::npos);
  EXPECT_FALSE(sessions.find(random_secret()));
  clock.advance(Sessions::kIdleLifetime + 1min);
  EXPECT_FALSE(sessions.find(secret));
}

TEST(Sessions, EndOldestOfUserWithTooMany) {
  VirtualClock clock;
  Sessions sessions("", clock);
  const auto ada = sessions.open("ada", "a password");
  std::vector<std::string> secrets;
  for (std::size_t i = 0; i < 2 * Sessions::kMaxSessions; ++i) {
    clock.advance(1s);
    secrets.push_back(sessions.open("eve", "a password"));
  }
  EXPECT_TRUE(sessions.find(ada));
  EXPECT_EQ(sessions.all().size(), Sessions::kMaxPerUser + 1);
  const auto oldest_kept = secrets.size() - Sessions::kMaxPerUser;
  EXPECT_FALSE(sessions.find(secrets[oldest_kept - 1]));
  for (auto i = oldest_kept; i < secrets.size(); ++i) EXPECT_TRUE(sessions.find(secrets[i])) << i;
}

TEST(Sessions, EndWhenClosedOrAfterWeek) {
  VirtualClock clock;
  Sessions sessions("", clock);
  const auto closed = sessions.open("ada", "a password"), used = sessions.open("ada", "a password");
  EXPECT_TRUE(sessions.close(sessions.find(closed)->id));
  EXPECT_FALSE(sessions.find(closed));
  for (Duration passed{}; passed < Sessions::kLifetime; passed += 6h) {
    ASSERT_TRUE(sessions.find(used));
    clock.advance(6h);
  }
  clock.advance(1h);
  EXPECT_FALSE(sessions.find(used));
}

/// Returns whether a restarted monitor accepts the secret.
bool is_revived(const std::string& file, const std::string& secret, const VirtualClock& clock) {
  Sessions sessions(file, clock);
  EXPECT_TRUE(sessions.load());
  return sessions.find(secret).has_value();
}

TEST(Sessions, ReportEndThatCannotBeStored) {
  const Site site;
  VirtualClock clock;
  const auto file = site.folder / "sessions.json";
  Sessions sessions(file, clock);
  const auto ada = sessions.open("ada", "a password"), eve = sessions.open("eve", "a password"),
             kept = sessions.open("bob", "a password");
  {
    const BlockedFile blocked(file);
    EXPECT_EQ(sessions.close(sessions.find(ada)->id).error().kind, FaultKind::storage);
    EXPECT_EQ(sessions.close_all_for_user("eve").error().kind, FaultKind::storage);
    EXPECT_EQ(sessions.store_again().error().kind, FaultKind::storage);
    EXPECT_FALSE(sessions.find(ada)) << "ended nevertheless";
    EXPECT_FALSE(sessions.find(eve));
    EXPECT_TRUE(sessions.find(kept));
  }
  EXPECT_TRUE(is_revived(file, ada, clock));
  EXPECT_TRUE(sessions.store_again());
  EXPECT_FALSE(is_revived(file, ada, clock));
  EXPECT_FALSE(is_revived(file, eve, clock));
  EXPECT_TRUE(is_revived(file, kept, clock));
}

TEST(Sessions, StoreEndLaterByThemselves) {
  const Site site;
  VirtualClock clock;
  const auto file = site.folder / "sessions.json";
  Sessions sessions(file, clock);
  const auto ended = sessions.open("ada", "a password");
  {
    const BlockedFile blocked(file);
    EXPECT_FALSE(sessions.close_all_for_user("ada"));
    EXPECT_FALSE(sessions.find(random_secret()));
  }
  EXPECT_TRUE(is_revived(file, ended, clock));
  clock.advance(2min);
  EXPECT_FALSE(sessions.find(random_secret()));
  EXPECT_FALSE(is_revived(file, ended, clock));
}

TEST(Confirmations, AreValidOnceForTheirCommandWithinHalfMinute) {
  VirtualClock clock;
  Confirmations confirmations(clock);
  const auto word = confirmations.issue_token("ada", "run", "stop");
  EXPECT_FALSE(confirmations.redeem(word, "eve", "run", "stop")) << "and it is used up";
  EXPECT_FALSE(confirmations.redeem(word, "ada", "run", "stop"));
  const auto second = confirmations.issue_token("ada", "run", "stop");
  EXPECT_TRUE(confirmations.redeem(second, "ada", "run", "stop"));
  EXPECT_FALSE(confirmations.redeem(second, "ada", "run", "stop"));
  const auto late = confirmations.issue_token("ada", "run", "stop");
  clock.advance(31s);
  EXPECT_FALSE(confirmations.redeem(late, "ada", "run", "stop"));
  EXPECT_FALSE(confirmations.redeem("", "ada", "run", "stop"));
}

TEST(Confirmations, SurviveFloodOfOtherUser) {
  VirtualClock clock;
  Confirmations confirmations(clock);
  const auto ada = confirmations.issue_token("ada", "run", "stop"),
             bob = confirmations.issue_token("bob", "run", "stop");
  for (int i = 0; i < 1000; ++i) (void)confirmations.issue_token("eve", std::to_string(i), "stop");
  for (int i = 0; i < 1000; ++i) (void)confirmations.issue_token("eve", "run", "stop");
  EXPECT_TRUE(confirmations.redeem(ada, "ada", "run", "stop"));
  EXPECT_TRUE(confirmations.redeem(bob, "bob", "run", "stop"));
}

TEST(Confirmations, ReplaceOldestOfUser) {
  VirtualClock clock;
  Confirmations confirmations(clock);
  std::vector<std::string> tokens;
  for (std::size_t i = 0; i <= Confirmations::kMaxPerUser; ++i) {
    tokens.push_back(confirmations.issue_token("ada", std::to_string(i), "stop"));
    clock.advance(1s);
  }
  EXPECT_FALSE(confirmations.redeem(tokens[0], "ada", "0", "stop"));
  for (std::size_t i = 1; i < tokens.size(); ++i)
    EXPECT_TRUE(confirmations.redeem(tokens[i], "ada", std::to_string(i), "stop")) << i;
}

TEST(Confirmations, ReplaceEarlierOfSameCommand) {
  VirtualClock clock;
  Confirmations confirmations(clock);
  const auto first = confirmations.issue_token("ada", "run", "stop"),
             other = confirmations.issue_token("ada", "run", "abort"),
             second = confirmations.issue_token("ada", "run", "stop");
  EXPECT_FALSE(confirmations.redeem(first, "ada", "run", "stop"));
  EXPECT_TRUE(confirmations.redeem(second, "ada", "run", "stop"));
  EXPECT_TRUE(confirmations.redeem(other, "ada", "run", "abort"));
}

TEST(RateLimit, LimitsTriesPerNameAndRecovers) {
  VirtualClock clock;
  RateLimit limit(3, 0.5, clock);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(limit.try_acquire("a"));
  EXPECT_FALSE(limit.try_acquire("a"));
  EXPECT_TRUE(limit.try_acquire("b"));
  clock.advance(2s);
  EXPECT_TRUE(limit.try_acquire("a"));
  EXPECT_FALSE(limit.try_acquire("a"));
}

TEST(RateLimit, AdmitsNewNamesWhenFull) {
  VirtualClock clock;
  RateLimit limit(3, 0.5, clock);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(limit.try_acquire("guesser"));
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(limit.try_acquire("user"));
  for (std::size_t i = 0; i < 2 * RateLimit::kMaxNames; ++i) ASSERT_TRUE(limit.try_acquire(std::to_string(i))) << i;
  EXPECT_FALSE(limit.try_acquire("guesser")) << "is not forgotten";
  EXPECT_TRUE(limit.try_acquire("user"));
  EXPECT_FALSE(limit.try_acquire("user")) << "is not forgotten either";
  clock.advance(10s);
  for (std::size_t i = 0; i < RateLimit::kMaxNames; ++i) ASSERT_TRUE(limit.try_acquire("late " + std::to_string(i)));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(limit.try_acquire("guesser"));
  EXPECT_FALSE(limit.try_acquire("guesser"));
}

TEST(ClientNetwork, IsSixtyFourBitsOfIpv6OrAnIpv4Address) {
  for (const auto& [address, network] :
       {std::pair("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"), std::pair("2001:DB8:1:2::", "2001:db8:1:2::/64"),
        std::pair("[2001:db8:1:2::9]:4711", "2001:db8:1:2::/64"), std::pair("[2001:db8:1:2::9]", "2001:db8:1:2::/64"),
        std::pair("2001:db8:1:3::", "2001:db8:1:3::/64"), std::pair("::1", "::/64"),
        std::pair("::ffff:192.0.2.1", "192.0.2.1"), std::pair("192.0.2.1", "192.0.2.1"),
        std::pair("192.0.2.1:4711", "192.0.2.1"), std::pair("unknown", "unknown"), std::pair("", "")})
    EXPECT_EQ(client_network(address), network) << address;
}

}  // namespace
}  // namespace gyrotherm::monitor
