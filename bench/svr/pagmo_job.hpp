/// The tuning job as the peer runs it: pagmo's particle swarm over the same box, 20 particles and 30 generations.
#pragma once

#include <functional>
#include <vector>

#include "bench/svr/libsvm_peer.hpp"
#include "bench/svr/trace.hpp"

namespace gyrotherm {

/// Evaluates one position.
using PositionFitness = std::function<Evaluated(const PeerParameters&)>;
/// Hears of each evaluation as soon as it is done.
using EvaluationSink = std::function<void(const TracePosition&)>;

/// pagmo::pso with ω = 0.7298, η₁ = η₂ = 2.05, velocity limit 0.5, variant 5, four neighbours, seed 42; box log2 C ∈
/// [−2, 12], log2 γ ∈ [−8, 3], log2 ε ∈ [−8, −1]. Returns the 620 positions in order.
[[nodiscard]] std::vector<TracePosition> run_pagmo_job(const PositionFitness& fitness, const EvaluationSink& sink = {});

}  // namespace gyrotherm
