#include "analysis/methods/network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/levenberg_marquardt.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kHidden = {5, 10, 20};
constexpr std::array kSteps = {5, 10, 15, 20, 30, 40, 60};
constexpr std::size_t kQuickHidden = 2, kQuickSteps = 6;  // how many of them
constexpr std::size_t kStarts = 10;

std::uint64_t seed_of(const MethodOptions& options, std::size_t start) { return options.seed * kStarts + start; }

/// The held-out predictions after each number of steps of one start.
Eigen::MatrixXd predictions_on_the_way(const Fold& fold, int hidden, std::uint64_t seed, std::span<const int> marks) {
  LevenbergMarquardt training(random_network(fold.train_x.cols(), hidden, seed), fold.train_x, fold.train_y);
  Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(marks.size()));
  int steps = 0;
  bool going = true;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    while (going && steps < marks[i]) {
      going = training.step();
      ++steps;
    }
    predicted.col(static_cast<Eigen::Index>(i)) = value_of(training.network(), fold.test_x);
  }
  return predicted;
}

/// Of the ten: the one that is the lower median of their errors after so many steps.
std::size_t median_start(std::span<const Eigen::VectorXd> starts, Eigen::Index steps) {
  std::array<std::size_t, kStarts> order{};
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::size_t start) { return starts[start](steps); });
  return order[(kStarts - 1) / 2];
}

}  // namespace

Result<Choice> choose_network(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  const auto sizes = std::span<const int>(kHidden).first(options.quick ? kQuickHidden : kHidden.size());
  const auto marks = std::span<const int>(kSteps).first(options.quick ? kQuickSteps : kSteps.size());
  const Trial train = [&](const Fold& fold, std::size_t trial) -> Result<Eigen::MatrixXd> {
    if (const auto sound = check_set({fold.train_x, fold.train_y, fold.terms}, 2); !sound)
      return failure(sound.error());
    return predictions_on_the_way(fold, sizes[trial / kStarts], seed_of(options, trial % kStarts), marks);
  };
  const auto errors = held_out_errors(folds, sizes.size() * kStarts, train, options, progress);
  if (!errors) return failure(errors.error());
  Choice choice;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t size = 0; size < sizes.size(); ++size) {
    const auto starts = std::span(*errors).subspan(size * kStarts, kStarts);
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(marks.size()); ++i) {
      const std::size_t median = median_start(starts, i);
      if (!(starts[median](i) < least)) continue;
      least = starts[median](i);
      choice.parameters = {{"hidden units", static_cast<double>(sizes[size])},
                           {"steps", static_cast<double>(marks[i])},
                           {"start", static_cast<double>(median)}};
    }
  }
  if (!choice.parameters.empty()) return choice;
  return failure(FaultKind::numeric, "network", "more than half of the starts have no finite held-out error");
}

Result<Fit> fit_network(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const int hidden = static_cast<int>(value_of(parameters, "hidden units"));
  const auto start = static_cast<std::size_t>(value_of(parameters, "start"));
  LevenbergMarquardt training(random_network(set.x.cols(), hidden, seed_of(options, start)), set.x, set.y);
  const int asked = static_cast<int>(value_of(parameters, "steps"));
  int steps = 0;
  while (steps < asked && training.step()) ++steps;
  const NetworkModel& network = training.network();
  const int weights = numbers_in(network);
  return Fit{.function = network,
             .effective_parameters = static_cast<double>(std::min<Eigen::Index>(weights, set.x.rows())),
             .particulars = fmt::format("stopped after {} steps, the median of {} starts; {} weights, which stopping "
                                        "early makes fewer in effect",
                                        steps, kStarts, weights)};
}

}  // namespace gyrotherm
