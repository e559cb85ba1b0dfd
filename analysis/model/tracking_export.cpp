// SPDX-License-Identifier: Apache-2.0
/// Writes bias tracking as C.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/model/export_parts.hpp"
#include "analysis/tracking/bias_tracker.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kDeclarations =
    R"(/* Tracks the residual bias by a Kalman filter while the gyro is known to be at rest.
   Noise parameters of the residual: angle random walk @N@ deg/sqrt(h), bias instability @B@ deg/h,
   rate random walk @K@ deg/h/sqrt(h), initial standard deviation @start@ deg/h. The filter gain settles at @gain@.
   The tracker contains the whole state. */
#define @name@_STATES @states@
typedef struct {
  double state[@name@_STATES];                      /* components of the bias: a random walk, Markov processes */
  double covariance[@name@_STATES][@name@_STATES]; /* covariance of their errors */
  double sum;                                       /* sum of the rates in this block of seconds */
  double left;                                      /* the predicted bias in this block */
  int seconds;                                      /* seconds in this block so far */
  int rests;                                        /* 1 if the gyro was at rest in all of them */
  int begun;                                        /* 1 after the first block */
} @name@_tracker;

void @name@_track_start(@name@_tracker *tracker);

/* Call once a second. rate_deg_per_h: rate of the gyro minus the Earth rate and the bias predicted by @name@_push.
   at_rest: not 0 if the gyro is at rest and this rate is valid. Returns the residual bias, to be subtracted as well.
   It is estimated only from earlier blocks of @name@_SECONDS, so a rotation in this block does not affect it. */
double @name@_track(@name@_tracker *tracker, double rate_deg_per_h, int at_rest);

)";

constexpr const char* kDefinitions =
    R"(/* For each state: fraction that remains after a block, variance that a block adds, initial variance. */
static const double memory[@name@_STATES] = {@memory@};
static const double fresh[@name@_STATES] = {@fresh@};
static const double initial[@name@_STATES] = {@initial@};
static const double white = @white@; /* variance of a block's mean about the bias */

void @name@_track_start(@name@_tracker *tracker) {
  for (int i = 0; i < @name@_STATES; ++i) {
    tracker->state[i] = 0.0;
    for (int j = 0; j < @name@_STATES; ++j) tracker->covariance[i][j] = i == j ? initial[i] : 0.0;
  }
  tracker->sum = 0.0;
  tracker->left = 0.0;
  tracker->seconds = 0;
  tracker->rests = 1;
  tracker->begun = 0;
}

static void pass_block(@name@_tracker *tracker) {
  for (int i = 0; i < @name@_STATES; ++i) {
    tracker->state[i] *= memory[i];
    for (int j = 0; j < @name@_STATES; ++j) tracker->covariance[i][j] *= memory[i] * memory[j];
    tracker->covariance[i][i] += fresh[i];
  }
}

/* Updates the covariance in Joseph form, which keeps it symmetric and positive. */
static void learn_mean(@name@_tracker *tracker, double mean) {
  double reach[@name@_STATES], gain[@name@_STATES], variance = white, innovation = mean;
  for (int i = 0; i < @name@_STATES; ++i) {
    reach[i] = 0.0;
    for (int j = 0; j < @name@_STATES; ++j) reach[i] += tracker->covariance[i][j];
    variance += reach[i];
    innovation -= tracker->state[i];
  }
  for (int i = 0; i < @name@_STATES; ++i) {
    gain[i] = reach[i] / variance;
    tracker->state[i] += gain[i] * innovation;
  }
  for (int i = 0; i < @name@_STATES; ++i) {
    for (int j = 0; j < @name@_STATES; ++j) {
      tracker->covariance[i][j] += variance * gain[i] * gain[j] - gain[i] * reach[j] - reach[i] * gain[j];
    }
  }
}

double @name@_track(@name@_tracker *tracker, double rate_deg_per_h, int at_rest) {
  const double left = tracker->left;
  if (at_rest && isfinite(rate_deg_per_h)) {
    tracker->sum += rate_deg_per_h;
  } else {
    tracker->rests = 0;
  }
  if (++tracker->seconds < @name@_SECONDS) return left;
  if (tracker->begun) pass_block(tracker);
  if (tracker->rests) learn_mean(tracker, tracker->sum / @name@_SECONDS);
  tracker->left = 0.0;
  for (int i = 0; i < @name@_STATES; ++i) tracker->left += memory[i] * tracker->state[i];
  tracker->sum = 0.0;
  tracker->seconds = 0;
  tracker->rests = 1;
  tracker->begun = 1;
  return left;
}

/* Rates of a few blocks, whether each was at rest, and the expected residual bias after each. */
static const double test_rate[] = {@rates@};
static const int test_rest[] = {@rests@};
static const double test_left[] = {@lefts@};

static int test_tracking(void) {
  @name@_tracker tracker;
  @name@_track_start(&tracker);
  for (int i = 0; i < (int)(sizeof test_rate / sizeof test_rate[0]); ++i) {
    for (int second = 0; second < @name@_SECONDS; ++second) @name@_track(&tracker, test_rate[i], test_rest[i]);
    if (!(fabs(tracker.left - test_left[i]) <= @tolerance@)) return 1;
  }
  return 0;
}

)";

constexpr const char* kNextLine = ",\n    ";

std::string c_lines(const std::vector<double>& values) {
  return c_list(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)), kNextLine);
}

/// Rates of a few blocks, all but one at rest, and the tracker's bias after each.
struct KnownTracking {
  std::vector<double> rates, lefts;
  std::vector<int> rests;
};

KnownTracking known_tracking(const tracking::StateSpace& space, int seconds) {
  constexpr int kBlocks = 10, kMovingBlock = 6;
  std::mt19937_64 random(1);
  const Eigen::VectorXd rates = draw(space, kBlocks, random).measured_deg_per_h;
  KnownTracking known;
  tracking::RestTracker tracker(space, seconds);
  for (int block = 0; block < kBlocks; ++block) {
    const bool rests = block != kMovingBlock;
    for (int second = 0; second < seconds; ++second) tracker.push(rates(block), rests);
    known.rates.push_back(rates(block));
    known.rests.push_back(rests ? 1 : 0);
    known.lefts.push_back(tracker.tracker().forecast(1).deg_per_h);
  }
  return known;
}

bool all_finite(const tracking::StateSpace& space, const KnownTracking& known) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::isfinite(space.white) && space.memory.allFinite() && space.fresh.allFinite() && space.start.allFinite() &&
         std::ranges::all_of(known.rates, finite) && std::ranges::all_of(known.lefts, finite);
}

}  // namespace

Result<CPart> tracking_in_c(const tracking::BiasNoise& noise, int seconds, std::string_view name) {
  const tracking::StateSpace space = state_space(noise, seconds);
  const KnownTracking known = known_tracking(space, seconds);
  if (!all_finite(space, known))
    return failure(FaultKind::usage, "C export",
                   "a bias tracking filter with this noise has a constant that is not finite");
  constexpr double kRelativeTolerance = 1e-12;
  const double scale = std::sqrt(space.start.sum() + space.white);
  const auto short_form = [](double value) { return fmt::format("{:.3g}", value); };
  const CPlaceholders placeholders = {{"name", std::string(name)},
                                      {"states", fmt::format("{}", tracking::kStates)},
                                      {"N", short_form(noise.angle_random_walk_deg_per_sqrt_h)},
                                      {"B", short_form(noise.instability_deg_per_h)},
                                      {"K", short_form(noise.rate_random_walk_deg_per_h_per_sqrt_h)},
                                      {"start", short_form(noise.start_deg_per_h)},
                                      {"gain", short_form(steady_state(space).gain.sum())},
                                      {"memory", c_list(space.memory, kNextLine)},
                                      {"fresh", c_list(space.fresh, kNextLine)},
                                      {"initial", c_list(space.start, kNextLine)},
                                      {"white", c_number(space.white)},
                                      {"rates", c_lines(known.rates)},
                                      {"rests", fmt::format("{}", fmt::join(known.rests, ", "))},
                                      {"lefts", c_lines(known.lefts)},
                                      {"tolerance", c_number(kRelativeTolerance * scale)}};
  return CPart{.declarations = c_fill(kDeclarations, placeholders),
               .definitions = c_fill(kDefinitions, placeholders),
               .test = "  if (test_tracking() != 0) return 1;\n"};
}

}  // namespace gyrotherm::model
