// SPDX-License-Identifier: Apache-2.0
#include "bench/svr/solvers.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <libsvm/svm.h>

#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "bench/measurement.hpp"

namespace gyrotherm::bench {

/// Functions of the library. Only members of svm_model that have the same offset in every release since 3.12 are read.
struct LibsvmPeer::Functions {
  decltype(&svm_train) train{};
  decltype(&svm_predict) predict{};
  decltype(&svm_get_sv_indices) support_indices{};
  decltype(&svm_free_and_destroy_model) destroy{};
  decltype(&svm_set_print_string_function) set_printer{};
};

namespace {

void say_nothing(const char*) {}

// Rows in the form of LIBSVM; the rows point into `nodes`.
struct PeerRows {
  std::vector<svm_node> nodes;
  std::vector<svm_node*> rows;

  explicit PeerRows(const svm::SampleMatrix& x) {
    const auto width = static_cast<std::size_t>(x.cols()) + 1;
    nodes.resize(static_cast<std::size_t>(x.rows()) * width);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      svm_node* row = nodes.data() + static_cast<std::size_t>(i) * width;
      for (Eigen::Index k = 0; k < x.cols(); ++k) row[k] = {static_cast<int>(k) + 1, x(i, k)};
      row[x.cols()].index = -1;
      rows.push_back(row);
    }
  }
};

// One training and its model, which refers to the rows and is released at the end.
class PeerTraining {
 public:
  PeerTraining(decltype(&svm_train) train, decltype(&svm_free_and_destroy_model) destroy, const svm::SampleMatrix& x,
               const Eigen::VectorXd& y, const PeerParameters& parameters)
      : destroy_(destroy), rows_(x), y_(y) {
    svm_problem problem{.l = static_cast<int>(x.rows()), .y = y_.data(), .x = rows_.rows.data()};
    svm_parameter options{};
    options.svm_type = EPSILON_SVR;
    options.kernel_type = RBF;
    options.gamma = parameters.gamma;
    options.C = parameters.C;
    options.p = parameters.epsilon;
    options.eps = 1e-3;
    options.cache_size = 200;
    options.shrinking = 1;
    const double start = thread_seconds();
    model_ = train(&problem, &options);
    seconds_ = thread_seconds() - start;
  }
  PeerTraining(const PeerTraining&) = delete;
  PeerTraining& operator=(const PeerTraining&) = delete;
  ~PeerTraining() { destroy_(&model_); }

  [[nodiscard]] const svm_model* model() const { return model_; }
  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] const std::vector<svm_node*>& rows() const { return rows_.rows; }

 private:
  decltype(&svm_free_and_destroy_model) destroy_;
  PeerRows rows_;
  Eigen::VectorXd y_;
  svm_model* model_{};
  double seconds_{};
};

}  // namespace

Result<LibsvmPeer> LibsvmPeer::open(const std::string& library) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) return failure(FaultKind::usage, library, dlerror());
  Functions functions;
  std::string missing;
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
    if (function == nullptr) missing = name;
  };
  find(functions.train, "svm_train");
  find(functions.predict, "svm_predict");
  find(functions.support_indices, "svm_get_sv_indices");
  find(functions.destroy, "svm_free_and_destroy_model");
  find(functions.set_printer, "svm_set_print_string_function");
  const auto* version = static_cast<const int*>(dlsym(handle, "libsvm_version"));
  if (version == nullptr) missing = "libsvm_version";
  if (!missing.empty()) return failure(FaultKind::usage, library, fmt::format("the function {} is missing", missing));
  functions.set_printer(say_nothing);
  LibsvmPeer peer;
  peer.version_ = *version;
  peer.functions_ = std::make_shared<const Functions>(functions);
  return peer;
}

PeerSolution LibsvmPeer::train(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                               const PeerParameters& parameters) const {
  const PeerTraining training(functions_->train, functions_->destroy, x, y, parameters);
  const svm_model* const model = training.model();
  std::vector<int> indices(static_cast<std::size_t>(model->l));
  functions_->support_indices(model, indices.data());
  PeerSolution solution{.beta = Eigen::VectorXd::Zero(y.size()), .b = -model->rho[0], .seconds = training.seconds()};
  for (std::size_t i = 0; i < indices.size(); ++i) solution.beta[indices[i] - 1] = model->sv_coef[0][i];
  return solution;
}

Evaluated LibsvmPeer::cross_validate(std::span<const svm::TuningFold> folds, const PeerParameters& parameters) const {
  Evaluated out;
  double squared = 0;
  Eigen::Index rows = 0;
  for (const svm::TuningFold& fold : folds) {
    const PeerTraining training(functions_->train, functions_->destroy, fold.train_x, fold.train_y, parameters);
    const PeerRows held_out(fold.test_x);
    const double start = thread_seconds();
    for (Eigen::Index i = 0; i < fold.test_y.size(); ++i) {
      const double error =
          functions_->predict(training.model(), held_out.rows[static_cast<std::size_t>(i)]) - fold.test_y[i];
      squared += error * error;
    }
    out.seconds += training.seconds() + thread_seconds() - start;
    rows += fold.test_y.size();
  }
  out.error = squared / static_cast<double>(rows);
  return out;
}

double LibsvmPeer::predictions_per_second(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                          const PeerParameters& parameters) const {
  const PeerTraining training(functions_->train, functions_->destroy, x, y, parameters);
  double sum = 0;
  const double seconds = median_seconds(3, [&] {
    for (const svm_node* row : training.rows()) sum += functions_->predict(training.model(), row);
  });
  assert(std::isfinite(sum));
  return static_cast<double>(training.rows().size()) / seconds;
}

svm::TuningOptions whole_job(int threads) {
  svm::TuningOptions options;
  options.swarm.stall_iterations = options.swarm.iterations + 1;
  options.swarm.threads = threads;
  return options;
}

Result<Evaluated> cross_validate_own(std::span<const svm::TuningFold> folds, const TracePosition& position) {
  constexpr double kWidth = 1e-9;
  const auto near = [](double value) { return std::pair{value, value + kWidth}; };
  svm::TuningOptions options = whole_job(1);
  options.log2_c = near(position.log2_c);
  options.log2_sigma = near(-0.5 * (1 + position.log2_gamma));
  options.log2_epsilon = near(position.log2_epsilon);
  options.swarm.particles = 2;
  options.swarm.iterations = 0;
  options.svr.relative_gap = kGap;
  std::vector<double> done;
  const auto summary = tune_svr(folds, options, [&](std::string_view, double) {
    done.push_back(thread_seconds());
    return true;
  });
  if (!summary) return failure(summary.error());
  if (summary->uncertified > 0 || done.size() < 2)
    return failure(FaultKind::numeric, "tuning",
                   fmt::format("{} of 2 evaluations missed the certificate", summary->uncertified));
  return Evaluated{.error = summary->cross_validation_mse, .seconds = done[1] - done[0]};
}

Result<double> reference_error(std::span<const svm::TuningFold> folds, const PeerParameters& parameters) {
  double squared = 0;
  Eigen::Index rows = 0;
  for (const svm::TuningFold& fold : folds) {
    const auto solution =
        solve_svr(fold.train_x, fold.train_y, own_parameters(parameters), {.relative_gap = 0.9 * kReferenceGap});
    if (!solution) return failure(solution.error());
    const Verdict verdict = assess_solution(fold.train_x, fold.train_y, parameters, solution->beta, solution->b);
    if (!verdict.feasible || !(verdict.gap <= kReferenceGap))
      return failure(FaultKind::numeric, "reference",
                     fmt::format("the relative gap is {:.2g}, expected at most {:g}", verdict.gap, kReferenceGap));
    squared +=
        (plain_prediction(fold.train_x, solution->beta, solution->b, parameters.gamma, fold.test_x) - fold.test_y)
            .squaredNorm();
    rows += fold.test_y.size();
  }
  return squared / static_cast<double>(rows);
}

}  // namespace gyrotherm::bench
