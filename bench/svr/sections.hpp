// SPDX-License-Identifier: Apache-2.0
/// The sections of the benchmark. Each prints its figures and fails only if it could not run. A solver that misses its
/// goal or its certificate results in a figure and not in a fault.
#pragma once

#include <string>
#include <vector>

#include "bench/svr/solvers.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Locations of data, and the peer of the comparison.
struct Bench {
  std::string data;    ///< folder of the sets
  std::string traces;  ///< folder of the traces NAME.trace
  LibsvmPeer peer;
};

/// Trains on one set in three cases (moderate, hard, very hard). Measures the speed ratios with and without kernel
/// set-up, and the duality gap as computed in judge.hpp.
[[nodiscard]] Result<void> measure_training(const Bench& bench, const std::string& set);
/// Measures a public set: the moderate and the hard case, with kernel set-up.
[[nodiscard]] Result<void> measure_public_set(const Bench& bench, const std::string& set);

struct ReplayOptions {
  std::string set = "gyro600";
  std::size_t positions = 20;
  double goal = 80;
  /// The trace replaces LIBSVM; only progress is printed.
  bool without_peer = false;
};
/// Measures a paired replay; the whole job, compared with LIBSVM's time as extrapolated from the replay; and the job on
/// two threads.
[[nodiscard]] Result<void> measure_tuning(const Bench& bench, const ReplayOptions& options);
[[nodiscard]] Result<void> measure_replay_alone(const Bench& bench, const ReplayOptions& options);
/// Runs pagmo's job with this project's fitness function, and compares its best error with that of the stored trace.
[[nodiscard]] Result<void> measure_pagmo_job(const Bench& bench, const std::string& set);

/// Counts the trainings at random positions of the search box that miss the certificate.
[[nodiscard]] Result<void> measure_search_box(const Bench& bench, int positions);
/// Measures points per second with 1000 support vectors on one thread.
[[nodiscard]] Result<void> measure_prediction(const Bench& bench);
/// Measures the peak memory of one hard training of 10,000 samples, in a process that does nothing else.
[[nodiscard]] Result<void> measure_memory(const Bench& bench);

/// Measures rows per second of `gyrotherm compensate` as text through a pipe. `scratch` must be an existing folder.
[[nodiscard]] Result<void> measure_compensation(const std::string& program, const std::string& scratch, int rows);
/// Measures the training stage of `gyrotherm qualify`, as recorded in its timings.
[[nodiscard]] Result<void> measure_qualification(const std::string& program, const std::string& scratch);

/// Prints a trace on stdout: pagmo's job with LIBSVM's fitness, or with that of this project if `own`.
[[nodiscard]] Result<void> make_trace(const Bench& bench, const std::string& set, bool own);

}  // namespace gyrotherm::bench
