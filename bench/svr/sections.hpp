// SPDX-License-Identifier: Apache-2.0
/// The sections of the benchmark. Each prints its figures; each fails only if it could not be run at all. A solver that
/// misses its goal, or its certificate, is a figure and not a fault.
#pragma once

#include <string>
#include <vector>

#include "bench/svr/solvers.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Where things are, and the peer that is compared with.
struct Bench {
  std::string data;    ///< folder of the sets
  std::string traces;  ///< folder of the stored traces, NAME.trace
  LibsvmPeer peer;
};

/// One training of one set in three cases (moderate, hard, very hard): gains with and without kernel set-up, and the
/// gap by the judge.
[[nodiscard]] Result<void> measure_training(const Bench& bench, const std::string& set);
/// One row for a public set: the moderate and the hard case, with kernel set-up.
[[nodiscard]] Result<void> measure_public_set(const Bench& bench, const std::string& set);

struct ReplayOptions {
  std::string set = "gyro600";
  std::size_t positions = 20;
  double goal = 80;
  bool without_peer = false;  ///< the trace stands for LIBSVM: nothing is printed but progress
};
/// Paired replay; our whole job against what the replay says LIBSVM would take for it; and our job on two threads.
[[nodiscard]] Result<void> measure_tuning(const Bench& bench, const ReplayOptions& options);
[[nodiscard]] Result<void> measure_replay_alone(const Bench& bench, const ReplayOptions& options);
/// Our fitness in pagmo's job: the same swarm as the trace's, and its best error.
[[nodiscard]] Result<void> measure_pagmo_job(const Bench& bench, const std::string& set);

/// Random positions of the search box: how many trainings miss the certificate.
[[nodiscard]] Result<void> measure_search_box(const Bench& bench, int positions);
/// Points a second with 1000 support vectors, one thread.
[[nodiscard]] Result<void> measure_prediction(const Bench& bench);
/// Most memory that one hard training of 10,000 samples holds, in a process that has done nothing else.
[[nodiscard]] Result<void> measure_memory(const Bench& bench);

/// Rows a second of `gyrotherm compensate` as text through a pipe; `scratch` is a folder that exists.
[[nodiscard]] Result<void> measure_compensation(const std::string& program, const std::string& scratch, int rows);
/// The training stage of `gyrotherm qualify`, as it writes it down itself.
[[nodiscard]] Result<void> measure_qualification(const std::string& program, const std::string& scratch);

/// Makes a trace: pagmo's job with LIBSVM's fitness, or with our `own`, on stdout.
[[nodiscard]] Result<void> make_trace(const Bench& bench, const std::string& set, bool own);

}  // namespace gyrotherm::bench
