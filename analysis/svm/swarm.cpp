// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/swarm.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "core/random.hpp"

namespace gyrotherm::svm {
namespace {

constexpr double kNoFitness = std::numeric_limits<double>::infinity();

struct Particle {
  std::vector<Coordinate> coordinates;
  std::vector<double> best;  // position
  double best_fitness = kNoFitness;

  [[nodiscard]] std::vector<double> position() const {
    std::vector<double> out;
    for (const Coordinate& coordinate : coordinates) out.push_back(coordinate.position);
    return out;
  }
};

Result<void> check(const SwarmBox& box, const SwarmOptions& options) {
  const auto bad = [](std::string what) { return failure(FaultKind::usage, "particle swarm", std::move(what)); };
  if (options.particles < 1) return bad(fmt::format("particles = {}, must be at least 1", options.particles));
  if (options.iterations < 0) return bad(fmt::format("iterations = {}, must be at least 0", options.iterations));
  if (options.threads < 0) return bad(fmt::format("threads = {}, must be at least 0", options.threads));
  if (options.stall_iterations < 1) {
    return bad(fmt::format("stall_iterations = {}, must be at least 1", options.stall_iterations));
  }
  if (!(options.v_max > 0)) return bad(fmt::format("v_max = {}, must be positive", options.v_max));
  if (!std::isfinite(options.v_max)) return bad(fmt::format("v_max = {}, must be finite", options.v_max));
  for (const double weight : {options.omega_max, options.omega_min, options.c1, options.c2, options.stall_gain}) {
    if (!(weight >= 0 && std::isfinite(weight))) {
      return bad(fmt::format("omega, c1, c2 and stall_gain must be at least 0 and finite; one is {}", weight));
    }
  }
  if (box.lower.empty() || box.lower.size() != box.upper.size()) {
    return bad(fmt::format("box has {} lower and {} upper limits", box.lower.size(), box.upper.size()));
  }
  for (std::size_t k = 0; k < box.lower.size(); ++k) {
    if (box.lower[k] <= box.upper[k] && std::isfinite(box.upper[k] - box.lower[k])) continue;
    return bad(fmt::format("coordinate {} has the limits {} and {}, must be finite and in order", k, box.lower[k],
                           box.upper[k]));
  }
  return {};
}

class Swarm {
 public:
  Swarm(const Fitness& fitness, const SwarmBox& box, const SwarmOptions& options, const ProgressSink& progress);
  Result<SwarmSummary> run();

 private:
  Result<void> evaluate(int iteration);
  void evaluate_one(std::size_t index, int iteration);
  void compare();
  void move(int iteration);
  [[nodiscard]] double fraction(int iteration, int done) const;
  // Counts iterations without a gain. Returns true if the swarm should stop.
  [[nodiscard]] bool update_stall_count();
  [[nodiscard]] std::vector<int> edges() const;

  const Fitness& fitness_;
  const SwarmBox& box_;
  const SwarmOptions& options_;
  const ProgressSink& progress_;
  std::mt19937_64 generator_;
  std::vector<Particle> particles_;
  // Values of the present iteration, by particle.
  std::vector<Result<double>> values_;
  tbb::task_arena arena_;
  std::thread::id caller_ = std::this_thread::get_id();
  // Number of evaluations in the present iteration.
  std::atomic<int> done_ = 0;
  std::atomic<bool> interrupted_ = false;
  double stall_reference_ = kNoFitness;
  int stall_count_ = 0;
  SwarmSummary summary_;
};

Swarm::Swarm(const Fitness& fitness, const SwarmBox& box, const SwarmOptions& options, const ProgressSink& progress)
    : fitness_(fitness),
      box_(box),
      options_(options),
      progress_(progress),
      generator_(options.seed),
      particles_(static_cast<std::size_t>(options.particles)),
      values_(particles_.size()),
      arena_(thread_count(options)) {
  for (Particle& particle : particles_) {
    for (std::size_t k = 0; k < box.lower.size(); ++k) {
      const double range = box.upper[k] - box.lower[k];
      const double position = box.lower[k] + range * uniform(generator_);
      const double velocity = options.v_max * range * (2 * uniform(generator_) - 1);
      particle.coordinates.push_back({position, velocity});
    }
    particle.best = particle.position();
  }
  summary_.best = particles_.front().best;
  summary_.best_fitness = kNoFitness;
}

double Swarm::fraction(int iteration, int done) const {
  const double rounds = options_.iterations + 1.0;
  return (iteration + done / static_cast<double>(options_.particles)) / rounds;
}

void Swarm::evaluate_one(std::size_t index, int iteration) {
  if (interrupted_) return;
  const Particle& particle = particles_[index];
  values_[index] = fitness_(index, particle.position(), particle.best_fitness);
  const int done = ++done_;
  if (std::this_thread::get_id() != caller_) return;
  if (!should_continue(progress_, "tuning", fraction(iteration, done))) interrupted_ = true;
}

Result<void> Swarm::evaluate(int iteration) {
  done_ = 0;
  arena_.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, particles_.size(), [&](std::size_t index) { evaluate_one(index, iteration); },
        tbb::simple_partitioner{});
  });
  if (interrupted_ || !should_continue(progress_, "tuning", fraction(iteration, options_.particles))) {
    return failure(FaultKind::interrupted, "particle swarm", fmt::format("stopped in iteration {}", iteration));
  }
  for (const Result<double>& value : values_) {
    if (!value) return failure(value.error());
  }
  summary_.evaluations += options_.particles;
  compare();
  return {};
}

void Swarm::compare() {
  for (std::size_t index = 0; index < particles_.size(); ++index) {
    Particle& particle = particles_[index];
    if (!(*values_[index] < particle.best_fitness)) continue;
    particle.best_fitness = *values_[index];
    particle.best = particle.position();
    if (particle.best_fitness >= summary_.best_fitness) continue;
    summary_.best_fitness = particle.best_fitness;
    summary_.best = particle.best;
  }
  summary_.history.push_back(summary_.best_fitness);
}

// Applies eq. 9 and moves the particles.
void Swarm::move(int iteration) {
  const double omega = inertia_weight(options_, iteration);
  for (Particle& particle : particles_) {
    for (std::size_t k = 0; k < particle.coordinates.size(); ++k) {
      Coordinate& now = particle.coordinates[k];
      const double r1 = uniform(generator_);
      const double r2 = uniform(generator_);
      now.velocity = omega * now.velocity + options_.c1 * r1 * (particle.best[k] - now.position) +
                     options_.c2 * r2 * (summary_.best[k] - now.position);
      now = move_within_box(now, options_.v_max * (box_.upper[k] - box_.lower[k]), box_.lower[k], box_.upper[k]);
    }
  }
}

bool Swarm::update_stall_count() {
  const bool gained = summary_.best_fitness < stall_reference_ - options_.stall_gain * std::abs(stall_reference_) ||
                      (stall_reference_ == kNoFitness && summary_.best_fitness < kNoFitness);
  if (gained) {
    stall_reference_ = summary_.best_fitness;
    stall_count_ = 0;
    return false;
  }
  return ++stall_count_ >= options_.stall_iterations;
}

std::vector<int> Swarm::edges() const {
  std::vector<int> out;
  for (std::size_t k = 0; k < summary_.best.size(); ++k) {
    if (summary_.best[k] == box_.lower[k] || summary_.best[k] == box_.upper[k]) out.push_back(static_cast<int>(k));
  }
  return out;
}

Result<SwarmSummary> Swarm::run() {
  if (auto ok = evaluate(0); !ok) return failure(ok.error());
  stall_reference_ = summary_.best_fitness;
  summary_.end = SwarmEnd::iterations_done;
  for (int iteration = 1; iteration <= options_.iterations; ++iteration) {
    move(iteration);
    if (auto ok = evaluate(iteration); !ok) return failure(ok.error());
    if (!update_stall_count()) continue;
    summary_.end = SwarmEnd::stalled;
    break;
  }
  summary_.coordinates_on_edge = edges();
  return std::move(summary_);
}

}  // namespace

int thread_count(const SwarmOptions& options) {
  const int available = tbb::info::default_concurrency();
  return options.threads == 0 ? available : std::min(options.threads, available);
}

double inertia_weight(const SwarmOptions& options, int t) {
  if (options.iterations == 0) return options.omega_max;
  return options.omega_max - (options.omega_max - options.omega_min) * t / options.iterations;
}

Coordinate move_within_box(Coordinate from, double v_max, double lower, double upper) {
  const double velocity = std::clamp(from.velocity, -v_max, v_max);
  const double position = from.position + velocity;
  if (position < lower) return {lower, 0};
  if (position > upper) return {upper, 0};
  return {position, velocity};
}

Result<SwarmSummary> minimise(const Fitness& fitness, const SwarmBox& box, const SwarmOptions& options,
                              const ProgressSink& progress) {
  if (auto ok = check(box, options); !ok) return failure(ok.error());
  return Swarm(fitness, box, options, progress).run();
}

const char* name(SwarmEnd end) {
  constexpr const char* kNames[] = {"was not run", "iterations done", "stalled"};
  return kNames[static_cast<std::size_t>(end)];
}

}  // namespace gyrotherm::svm
