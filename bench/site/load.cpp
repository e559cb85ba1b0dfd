// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-site-load: simulates rigs with active runs that send one row per second of a recorded run to a store, and
/// measures the delay of each row.
#include <fmt/format.h>
#include <poll.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include "acquisition/record/run_source.hpp"
#include "apps/site/run_text.hpp"
#include "apps/site/store.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/sha256.hpp"

namespace {

using gyrotherm::Duration;
using gyrotherm::Result;
using gyrotherm::site::RowBatch;
using gyrotherm::site::Store;

struct Options {
  std::string store;
  std::string record;
  int rigs = 1000;
  int connections = 8;
  int seconds = 60;
};

/// Data that every rig sends: the description of a run and the rows of its first seconds.
struct Recorded {
  std::string json;
  /// Array elements, one per row, such as "{1.5,NULL}" with its quotes.
  std::vector<std::string> rows;
};

constexpr int kMostRows = 600;
constexpr Duration kSecond = std::chrono::seconds(1);

Result<Recorded> read(const std::string& path) {
  const auto files = gyrotherm::record::find_source_files(path, false);
  if (!files) return gyrotherm::failure(files.error());
  const auto info = gyrotherm::record::read_source_info(*files);
  if (!info) return gyrotherm::failure(info.error());
  Recorded recorded{.json = gyrotherm::site::run_as_json(*info), .rows = {}};
  const auto channels = gyrotherm::site::stored_channels(*info);
  for (std::int64_t last = -1; recorded.rows.size() < kMostRows;) {
    const auto batch = gyrotherm::site::read_rows(*files, channels, last, 1);
    if (!batch) return gyrotherm::failure(batch.error());
    if (batch->rows == 0) break;
    recorded.rows.push_back(batch->numbers.substr(1, batch->numbers.size() - 2));
    last = batch->last;
  }
  return recorded;
}

/// Returns the rows of a run from `first` to `last`.
RowBatch make_batch(const Recorded& recorded, int first, int last) {
  RowBatch batch{.after = first - 1, .last = last};
  for (int slot = first; slot <= last; ++slot) {
    const char* comma = slot == first ? "" : ",";
    batch.slots += fmt::format("{}{}", comma, slot);
    batch.utcs += fmt::format("{}{}", comma, slot * 1'000'000'000LL);
    batch.numbers += comma + recorded.rows[static_cast<std::size_t>(slot) % recorded.rows.size()];
    ++batch.rows;
  }
  for (auto* text : {&batch.slots, &batch.utcs, &batch.numbers}) *text += '}';
  return batch;
}

struct Rig {
  std::string run;
  Duration phase{};  ///< within a second
  int sent = -1;
};

struct Lags {
  std::mutex mutex;
  std::vector<double> seconds;
  std::vector<std::string> failures;

  void fail(const gyrotherm::Fault& fault) {
    const std::lock_guard lock(mutex);
    failures.push_back(text(fault));
  }
};

/// Sends the rows of the rigs that belong to one connection. The most overdue rig is first.
void send_all(const Options& options, const Recorded& recorded, int number, const gyrotherm::Clock& clock, Lags& lags) {
  auto store = Store::open({options.store}, {});
  if (!store) return lags.fail(store.error());
  std::vector<Rig> rigs;
  for (int rig = number; rig < options.rigs; rig += options.connections) {
    rigs.push_back(
        {.run = gyrotherm::sha256(fmt::format("load {}", rig)).substr(0, 32), .phase = kSecond * rig / options.rigs});
    if (const auto added = store->add_run(rigs.back().run, fmt::format("load-{}", rig), recorded.json); !added)
      return lags.fail(added.error());
  }
  const auto begun = clock.now().since_start;
  std::vector<double> own;
  for (bool all_sent = false; !all_sent;) {
    all_sent = true;
    Duration next = kSecond;
    for (auto& rig : rigs) {
      const auto since = clock.now().since_start - begun - rig.phase;
      const int due = std::min(static_cast<int>(since / kSecond), options.seconds) - 1;
      all_sent = all_sent && rig.sent == options.seconds - 1;
      if (due <= rig.sent) {
        next = std::min(next, kSecond * (rig.sent + 2) - since);
        continue;
      }
      const auto sent = store->send_rows(rig.run, make_batch(recorded, rig.sent + 1, due)).and_then([&] {
        return store->await_rows();
      });
      if (!sent) return lags.fail(sent.error());
      const auto now = clock.now().since_start - begun - rig.phase;
      for (int slot = rig.sent + 1; slot <= due; ++slot)
        own.push_back(gyrotherm::to_seconds(now - kSecond * (slot + 1)));
      rig.sent = due;
      next = {};
    }
    if (next > Duration{})
      static_cast<void>(gyrotherm::wait_until_ready(gyrotherm::kNoDescriptor, POLLIN, gyrotherm::Deadline(next)));
  }
  const std::lock_guard lock(lags.mutex);
  lags.seconds.insert(lags.seconds.end(), own.begin(), own.end());
}

int run(const Options& options) {
  const auto recorded = read(options.record);
  if (!recorded) {
    fmt::print(stderr, "{}\n", text(recorded.error()));
    return 1;
  }
  const gyrotherm::SteadyClock clock;
  Lags lags;
  std::vector<std::thread> threads;
  for (int i = 0; i < options.connections; ++i)
    threads.emplace_back([&, i] { send_all(options, *recorded, i, clock, lags); });
  for (auto& thread : threads) thread.join();
  std::ranges::sort(lags.seconds);
  for (const auto& failure : lags.failures) fmt::print(stderr, "{}\n", failure);
  if (!lags.failures.empty() || lags.seconds.empty()) return 1;
  const auto at = [&](double share) {
    return lags.seconds[static_cast<std::size_t>(share * static_cast<double>(lags.seconds.size() - 1))];
  };
  fmt::print("rows\t{}\nlag median s\t{:.3f}\nlag 99 % s\t{:.3f}\nlag longest s\t{:.3f}\n", lags.seconds.size(),
             at(0.5), at(0.99), at(1));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("Simulates rigs that each send one row per second to a store.");
  cli.add_option("--store", options.store, "connection to the store")->required();
  cli.add_option("--record", options.record, "run whose rows are sent")->required();
  cli.add_option("--rigs", options.rigs)->capture_default_str()->check(CLI::Range(1, 100000));
  cli.add_option("--connections", options.connections)->capture_default_str()->check(CLI::Range(1, 2000));
  cli.add_option("--seconds", options.seconds)->capture_default_str()->check(CLI::Range(1, 1000000));
  CLI11_PARSE(cli, argc, argv);
  return run(options);
}
