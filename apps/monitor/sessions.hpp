// SPDX-License-Identifier: Apache-2.0
/// Who is logged in, what a session may still ask to be confirmed, and how often an address may ask at all.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// Logged-in users. A session is known by the SHA-256 of a random secret that its browser has in a cookie; the list is
/// kept in a file (mode 0600), so that nobody is logged out when the monitor is started anew. Any thread.
class Sessions {
 public:
  struct Session {
    std::string id;  ///< SHA-256 of the secret
    std::string user;
    std::string known_by;      ///< what the user was known by when it began (Identity::known_by)
    std::string csrf;          ///< a second secret, which a page must send along with what changes something
    Duration begun{}, used{};  ///< UTC
  };
  static constexpr Duration kLongest = std::chrono::hours(7 * 24), kLongestUnused = std::chrono::hours(12);
  static constexpr std::size_t kMost = 256;  ///< of more the one that was used longest ago ends

  /// An empty `path` keeps them in memory alone.
  Sessions(std::string path, const Clock& clock) : path_(std::move(path)), clock_(clock) {}

  /// Fails with bad_file.
  [[nodiscard]] Result<void> load();
  /// A new session; the secret for the cookie.
  [[nodiscard]] std::string open(const std::string& user, const std::string& known_by);
  [[nodiscard]] std::optional<Session> find(const std::string& secret);
  void close(const std::string& id);
  void close_all_of(const std::string& user);
  [[nodiscard]] std::vector<Session> all();

 private:
  void drop_old();
  void save() const;

  std::string path_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Session> sessions_;  ///< by id
};

/// What somebody was asked whether they are sure of: a word of which they may make use once, within 30 s. Any thread.
class Confirmations {
 public:
  static constexpr Duration kWithin = std::chrono::seconds(30);
  explicit Confirmations(const Clock& clock) : clock_(clock) {}

  /// For that person, that run and that verb.
  [[nodiscard]] std::string ask(const std::string& who, const std::string& run, const std::string& verb);
  /// Whether it is one, which it is not a second time.
  [[nodiscard]] bool take(const std::string& word, const std::string& who, const std::string& run,
                          const std::string& verb);

 private:
  struct Asked {
    std::string what;
    Duration at{};
  };
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Asked> asked_;
};

/// Each name (an address, a user) has so many tries, of which it gets back so many a second. Any thread.
class RateLimit {
 public:
  RateLimit(double most, double per_second, const Clock& clock) : most_(most), per_second_(per_second), clock_(clock) {}

  /// Takes one; false if there is none left.
  [[nodiscard]] bool take(const std::string& name);

 private:
  struct Left {
    double tries{};
    Duration at{};
  };
  static constexpr std::size_t kMostNames = 4096;
  double most_, per_second_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Left> left_;
};

}  // namespace gyrotherm::monitor
