// SPDX-License-Identifier: Apache-2.0
/// Users of the page, stored in a file that only gyrotherm-monitor writes (mode 0600): names, roles, and hashes of
/// passwords and tokens. A password is stored as libsodium's argon2id, a token as its SHA-256; neither can be
/// recovered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kUsersSchema = "gyrotherm-monitor-users/1";

/// Roles. Each includes the rights of the previous ones.
enum class Role {
  /// Views runs.
  viewer,
  /// Controls runs; "operator" in files and on command lines.
  conductor,
  /// Views and ends sessions.
  administrator,
};
inline constexpr std::initializer_list<Role> kRoles = {Role::viewer, Role::conductor, Role::administrator};
[[nodiscard]] inline const char* name(Role role) {
  return enumerator_text<Role::administrator>({"viewer", "operator", "administrator"}, role);
}
[[nodiscard]] std::optional<Role> find_role(std::string_view word);

struct User {
  std::string name;
  Role role{};
  /// argon2id string.
  std::string password;
};
/// A token of a script.
struct Token {
  std::string name;
  Role role{};
  /// Hash of the token's text.
  std::string sha256;
};

/// The sender of a request.
struct Identity {
  std::string name;
  Role role{};
  /// SHA-256 of a user's stored password hash, which changes with each password.
  std::string password_id{};
};

/// Content of the file.
struct UserList {
  std::vector<User> users;
  std::vector<Token> tokens;
};

/// Reads the file. Returns an empty list if it does not exist. Fails with bad_file, also if other users may read it.
[[nodiscard]] Result<UserList> read_users(const std::string& path);
/// Replaces the file atomically. Fails with storage.
[[nodiscard]] Result<void> write_users(const std::string& path, const UserList& list);

inline constexpr std::size_t kMinPasswordBytes = 10, kMaxPasswordBytes = 256;  ///< bytes

/// Adds a user, or replaces role and password of an existing one. Fails with usage if the name is invalid or the length
/// of the password is not permitted.
[[nodiscard]] Result<void> put_user(UserList& list, const std::string& name, Role role, const std::string& password);
/// Adds a token, or replaces the one of that name. Returns its text, which cannot be recovered later. Fails with usage.
[[nodiscard]] Result<std::string> put_token(UserList& list, const std::string& name, Role role);
/// Removes a user or a token. Fails with usage if there is none.
[[nodiscard]] Result<void> remove_name(UserList& list, const std::string& name);

/// Returns 256 random bits as 43 characters of URL-safe base 64.
[[nodiscard]] std::string random_secret();
/// Compares in constant time: the duration does not depend on the first difference.
[[nodiscard]] bool equal_secrets(std::string_view a, std::string_view b);

/// The users of a running monitor. The file is read again after it has changed. Usable from any thread.
class Users {
 public:
  explicit Users(std::string path) : path_(std::move(path)) {}

  /// Loads the users. Fails like read_users().
  [[nodiscard]] Result<void> load();
  /// Returns whether there is a user or token, or a file that cannot be read.
  [[nodiscard]] bool has_any();
  /// Finds a user by name and password. Takes about a tenth of a second and 12 MB, one call at a time, and equally long
  /// for an unknown name.
  [[nodiscard]] std::optional<Identity> find_by_password(const std::string& name, const std::string& password);
  [[nodiscard]] std::optional<Identity> find_by_token(std::string_view token);
  /// Finds a user by name, with the present role.
  [[nodiscard]] std::optional<Identity> find_by_name(const std::string& name);

 private:
  void refresh();

  std::string path_;
  std::mutex mutex_, hashing_mutex_;
  UserList list_;
  /// The file exists and cannot be read.
  bool is_unreadable_{};
  /// State of the file when it was read.
  FileState seen_;
};

}  // namespace gyrotherm::monitor
