// SPDX-License-Identifier: Apache-2.0
/// gyrotherm-svr-bench: runs one section of the benchmark per call. bench/svr/compare calls all of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <limits>

#include "bench/measurement.hpp"
#include "bench/svr/sections.hpp"
#include "bench/svr/tuning_material.hpp"

namespace gyrotherm::bench {
namespace {

struct Options {
  std::string data = ".";
  std::string traces = GYROTHERM_TRACES;
  std::vector<std::string> libraries{"libsvm.so.3"};
  std::string set = "gyro600";
  std::string program;
  std::string scratch = ".";
  ReplayOptions replay;
  int count = 0;
  bool own = false;
};

/// Returns the library that trains the hard case of gyro600 fastest.
Result<LibsvmPeer> fastest_peer(const Options& options) {
  std::optional<LibsvmPeer> best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& library : options.libraries) {
    auto peer = LibsvmPeer::open(library);
    if (!peer) return failure(peer.error());
    if (options.libraries.size() == 1) return *peer;
    const auto set = load_sample_set(options.data, "gyro600");
    if (!set) return failure(set.error());
    std::vector<double> times;
    for (int i = 0; i < 3; ++i) times.push_back(peer->train(set->x, set->y, {100, 0.1, 0.01}).seconds);
    print_progress(fmt::format("LIBSVM {} of {}: {:.4f} s", peer->version(), library, median(times)));
    if (median(times) >= least) continue;
    least = median(times);
    best = *peer;
  }
  return *best;
}

using Section = std::function<Result<void>(const Bench&)>;

void add_sections(CLI::App& app, Options& options, Section& chosen) {
  const auto add = [&](const char* name, const char* what, Section section) {
    auto* const command = app.add_subcommand(name, what);
    command->callback([&chosen, section = std::move(section)] { chosen = section; });
    return command;
  };
  const auto with_set = [&](CLI::App* command) { command->add_option("--set", options.set, "name of the set"); };
  const auto with_replay = [&](CLI::App* command) {
    command->add_option("--set", options.replay.set, "name of the set");
    command->add_option("--positions", options.replay.positions, "number of positions, evenly spaced over the trace");
    command->add_option("--goal", options.replay.goal, "required gain over the peer");
  };
  const auto with_program = [&](CLI::App* command) {
    command->add_option("--program", options.program, "path of gyrotherm")->required();
    command->add_option("--scratch", options.scratch, "existing folder for temporary files");
  };
  auto* const replay = add("replay", "replay stored positions with both solvers and report on stderr",
                           [&](const Bench& bench) { return measure_replay_alone(bench, options.replay); });
  with_replay(replay);
  replay->add_flag("--without-peer", options.replay.without_peer, "use the results of the trace instead of LIBSVM");
  with_replay(add("tuning", "measure the replay and our whole job on one and two threads",
                  [&](const Bench& bench) { return measure_tuning(bench, options.replay); }));
  with_set(add("pagmo", "run pagmo's job with our fitness function",
               [&](const Bench& bench) { return measure_pagmo_job(bench, options.set); }));
  auto* const trace = add("trace", "run pagmo's job with LIBSVM and print its trace",
                          [&](const Bench& bench) { return make_trace(bench, options.set, options.own); });
  with_set(trace);
  trace->add_flag("--own", options.own, "use our solver instead of LIBSVM");
  with_set(add("training", "measure one training in three cases",
               [&](const Bench& bench) { return measure_training(bench, options.set); }));
  with_set(add("public", "measure one training of a public set",
               [&](const Bench& bench) { return measure_public_set(bench, options.set); }));
  add("box", "train at random positions of the search box",
      [&](const Bench& bench) { return measure_search_box(bench, options.count); })
      ->add_option("--positions", options.count, "number of positions")
      ->required();
  add("prediction", "measure predicted points per second", measure_prediction);
  add("memory", "measure the peak memory of one training at n = 10,000", measure_memory);
  auto* const compensation = add("compensation", "measure rows per second of gyrotherm compensate", [&](const Bench&) {
    return measure_compensation(options.program, options.scratch, options.count);
  });
  with_program(compensation);
  compensation->add_option("--rows", options.count, "number of rows")->required();
  with_program(add("qualification", "measure the training stage of gyrotherm qualify",
                   [&](const Bench&) { return measure_qualification(options.program, options.scratch); }));
}

int run(int argc, char** argv) {
  Options options;
  Section chosen;
  CLI::App app{"Runs one section of the benchmark of ε-SVR and its tuning, compared with LIBSVM and pagmo."};
  app.add_option("--data", options.data, "folder with the sets of make_sets.py");
  app.add_option("--traces", options.traces, "folder of the stored traces");
  app.add_option("--libsvm", options.libraries, "shared libraries of LIBSVM; the fastest is the peer");
  app.require_subcommand(1);
  add_sections(app, options, chosen);
  CLI11_PARSE(app, argc, argv);
  auto peer = fastest_peer(options);
  const auto done = peer ? chosen({options.data, options.traces, *peer}) : Result<void>(failure(peer.error()));
  if (done) return 0;
  fmt::print(stderr, "{}\n", text(done.error()));
  return done.error().kind == FaultKind::usage ? 2 : 4;
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) { return gyrotherm::bench::run(argc, argv); }
