// SPDX-License-Identifier: Apache-2.0
/// One connection to a PostgreSQL server, and the answers that come over it. Nothing here waits without a bound, and
/// every wait ends when the program is asked to stop.
///
/// Faults say what is to be done: interrupted, somebody asked for an end; disconnected and timeout, the server or the
/// network is not there, and a new connection may find it; storage, the server cannot now (its disk is full, it shuts
/// down, it gave way to another transaction); refused, it will say the same again (SQLSTATE classes 0A, 22, 23, 28, 42,
/// P0). One thread at a time.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

struct pg_conn;
struct pg_result;

namespace gyrotherm::site {

/// Where the store is and how one gets in. There is no password in it: it comes from a file alone.
struct StoreAddress {
  std::string conninfo;    ///< as libpq reads it: "host=db dbname=gyrotherm user=rig_1 sslmode=verify-full"
  std::string passfile{};  ///< in the form of libpq's (host:port:database:user:password); empty: ~/.pgpass
};

/// The place of a fault that the server, or the way to it, had.
inline constexpr const char* kStore = "store";

/// Fails with usage if the text is no conninfo, or has a password in it.
[[nodiscard]] Result<void> check_conninfo(const std::string& conninfo);

/// How long is waited, and what ends that early.
struct Patience {
  Duration connect = std::chrono::seconds(10);
  Duration answer = std::chrono::seconds(60);
  int stop = kNoDescriptor;  ///< readable once the program is to end
};

/// The rows of an answer.
class Answer {
 public:
  explicit Answer(pg_result* result) : result_(result) {}
  [[nodiscard]] int rows() const;
  [[nodiscard]] int columns() const;
  [[nodiscard]] std::string name(int column) const;
  [[nodiscard]] bool null(int row, int column) const;
  [[nodiscard]] std::string_view text(int row, int column) const;  ///< empty where NULL
  [[nodiscard]] std::int64_t integer(int row, int column) const;   ///< 0 where there is none
  [[nodiscard]] bool boolean(int row, int column) const;
  [[nodiscard]] unsigned type(int column) const;  ///< PostgreSQL's number of it

 private:
  struct Clear {
    void operator()(pg_result* result) const;
  };
  std::unique_ptr<pg_result, Clear> result_;
};

/// A value of a statement, as text; nothing is NULL.
using Parameter = std::optional<std::string>;

class Postgres {
 public:
  /// Fails as said above, with bad_file if the passfile is not there or others may read it.
  [[nodiscard]] static Result<Postgres> connect(const StoreAddress& address, const Patience& patience);

  /// Sends one statement with its parameters, $1 first, and waits for its answer.
  [[nodiscard]] Result<Answer> ask(const std::string& statement, const std::vector<Parameter>& parameters = {});
  /// Sends one, and returns as soon as the server has it; its answer() must be fetched before the next is sent.
  [[nodiscard]] Result<void> send(const std::string& statement, const std::vector<Parameter>& parameters);
  [[nodiscard]] Result<Answer> answer();
  /// Sends statements without parameters, several in one text: a transaction, unless they say otherwise.
  [[nodiscard]] Result<void> run(const std::string& statements);

  /// Whether nothing but a new connection helps.
  [[nodiscard]] bool is_broken() const;
  /// "host=db dbname=gyrotherm user=rig_1, TLSv1.3": what one is connected to.
  [[nodiscard]] std::string place() const;

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  Postgres(pg_conn* connection, const Patience& patience) : connection_(connection), patience_(patience) {}
  [[nodiscard]] Result<void> wait_until_connected();
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> wait(short events, Duration within);
  [[nodiscard]] tl::unexpected<Fault> lost() const;

  std::unique_ptr<pg_conn, Finish> connection_;
  Patience patience_;
};

}  // namespace gyrotherm::site
