// SPDX-License-Identifier: Apache-2.0
#include "apps/site/store.hpp"

#include <fmt/format.h>

namespace gyrotherm::site {

Result<Store> Store::open(const StoreAddress& address, const WaitLimits& limits) {
  auto connection = Postgres::connect(address, limits);
  if (!connection) return failure(connection.error());
  // A store that was created before the first release has a higher version number, but its say_state() has other
  // parameters.
  const auto version = connection->query(
      "SELECT gyrotherm.version(), to_regprocedure('gyrotherm.say_state(uuid, text, text, jsonb)') IS NOT NULL");
  if (!version && version.error().kind == FaultKind::refused)
    return failure(FaultKind::refused, kStore, fmt::format("is not set up for this user: {}", version.error().what));
  if (!version) return failure(version.error());
  if (version->integer(0, 0) < kOldestStore || !version->boolean(0, 1))
    return failure(FaultKind::refused, kStore, "is older than this program; run \"gyrotherm site migrate\" first");
  return Store(std::move(*connection), version->integer(0, 0));
}

Result<void> Store::call(const std::string& statement, const std::vector<Parameter>& parameters) {
  return connection_.query(statement, parameters).map([](const QueryResult&) {});
}

Result<std::optional<RunPosition>> Store::position(const std::string& run) {
  const auto answer = connection_.query(
      "SELECT last_slot, last_event, last_gap, finished, dropped FROM gyrotherm.run_position($1)", {run});
  if (!answer) return failure(answer.error());
  if (answer->rows() == 0) return std::nullopt;
  return RunPosition{.slot = answer->integer(0, 0),
                     .event = answer->integer(0, 1),
                     .gap = answer->integer(0, 2),
                     .finished = answer->boolean(0, 3),
                     .dropped = answer->boolean(0, 4)};
}

Result<void> Store::add_run(const std::string& run, const std::string& rig, const std::string& json) {
  return call("SELECT gyrotherm.add_run($1, $2, $3)", {run, rig, json});
}

Result<void> Store::add_segments(const std::string& run, const std::string& json) {
  return call("SELECT gyrotherm.add_segments($1, $2)", {run, json});
}

Result<void> Store::send_rows(const std::string& run, const RowBatch& batch) {
  return connection_.send("SELECT gyrotherm.add_rows($1, $2, $3, $4, $5)",
                          {run, std::to_string(batch.after), batch.slots, batch.utcs, batch.numbers});
}

Result<void> Store::await_rows() {
  return connection_.read_result().map([](const QueryResult&) {});
}

Result<void> Store::add_events(const std::string& run, std::int64_t after, const std::string& json) {
  return call("SELECT gyrotherm.add_events($1, $2, $3)", {run, std::to_string(after), json});
}

Result<void> Store::add_gaps(const std::string& run, std::int64_t after, const std::string& json) {
  return call("SELECT gyrotherm.add_gaps($1, $2, $3)", {run, std::to_string(after), json});
}

Result<void> Store::update_state(const std::string& run, const LiveState& now) {
  return call("SELECT gyrotherm.say_state($1, $2, $3, $4)", {run, now.state, now.cause, now.alarms});
}

Result<void> Store::finish_run(const std::string& run, const std::string& json) {
  return call("SELECT gyrotherm.finish_run($1, $2)", {run, json});
}

Result<bool> Store::has_document(const std::string& sha256) {
  return connection_.query("SELECT gyrotherm.has_document($1)", {sha256}).map([](const QueryResult& answer) {
    return answer.boolean(0, 0);
  });
}

Result<void> Store::add_document(const std::string& rig, const Document& document) {
  return call("SELECT gyrotherm.add_document($1, $2, $3, $4)", {rig, document.kind, document.name, document.text});
}

Result<void> Store::add_check_standard(const std::string& rig, const CheckCharts& charts) {
  return call("SELECT gyrotherm.add_check_standard($1, $2, $3)", {rig, charts.history, charts.json});
}

}  // namespace gyrotherm::site
