// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/conjugate_gradients.hpp"

#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <HYPRE.h>
#include <HYPRE_IJ_mv.h>
#include <HYPRE_krylov.h>
#include <HYPRE_parcsr_ls.h>
#include <HYPRE_utilities.h>
#include <fmt/format.h>
#include <mpi.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>
#include <numeric>
#include <utility>
#include <vector>

namespace gyrotherm::thermal {
namespace {

/// Saves the handlers of all signals and restores them.
class SignalHandlers {
 public:
  SignalHandlers() {
    for (int s = 1; s < NSIG; ++s) kept_[s] = sigaction(s, nullptr, &handlers_[s]) == 0;
  }
  ~SignalHandlers() {
    for (int s = 1; s < NSIG; ++s)
      if (kept_[s]) sigaction(s, &handlers_[s], nullptr);
  }
  SignalHandlers(const SignalHandlers&) = delete;
  SignalHandlers& operator=(const SignalHandlers&) = delete;

 private:
  std::array<struct sigaction, NSIG> handlers_{};
  std::array<bool, NSIG> kept_{};
};

/// Sets an environment variable during its lifetime. A variable that is already set is unchanged.
class Setting {
 public:
  Setting(const char* name, const char* value) : name_(name), ours_(std::getenv(name) == nullptr) {
    if (ours_) setenv(name, value, 1);
  }
  ~Setting() {
    if (ours_) unsetenv(name_);
  }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  bool ours_;
};

class Session {
 public:
  Session() : process_(getpid()) {
    int running = 0;
    MPI_Initialized(&running);
    if (running == 0) {
      const SignalHandlers handlers;
      // Prevents MPI from starting a daemon that needs a network.
      const Setting alone("OMPI_MCA_ess_singleton_isolated", "1");
      // Prevents MPI from using a session folder that all processes of a user share: one process could remove it at its
      // end while another process starts.
      const Setting folders("OMPI_MCA_orte_create_session_dirs", "0");
      const Setting transport("OMPI_MCA_btl", "self");
      const Setting messages("OMPI_MCA_pml", "ob1");
      MPI_Init(nullptr, nullptr);
      ours_ = true;
    }
    HYPRE_Init();
  }
  ~Session() {
    // A forked child must not shut down its parent's message passing.
    if (!ours_ || getpid() != process_) return;
    const SignalHandlers handlers;
    HYPRE_Finalize();
    int ended = 0;
    MPI_Finalized(&ended);
    if (ended == 0) MPI_Finalize();
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  pid_t process_;
  bool ours_ = false;
};

/// Starts the message passing that hypre needs, once, for this process only. It ends with the process. Signal handlers
/// do not change.
void start_message_passing() { static const Session session; }

HYPRE_IJVector make_vector(int size, HYPRE_ParVector& parallel) {
  HYPRE_IJVector vector{};
  HYPRE_IJVectorCreate(MPI_COMM_SELF, 0, size - 1, &vector);
  HYPRE_IJVectorSetObjectType(vector, HYPRE_PARCSR);
  HYPRE_IJVectorInitialize(vector);
  HYPRE_IJVectorAssemble(vector);
  void* object = nullptr;
  HYPRE_IJVectorGetObject(vector, &object);
  parallel = static_cast<HYPRE_ParVector>(object);
  return vector;
}

/// Returns and clears the errors of hypre, which it keeps until they are cleared.
int errors() {
  const int noted = HYPRE_GetError();
  HYPRE_ClearAllErrors();
  return noted;
}

Fault fault(int noted) {
  std::array<char, 256> text{};
  HYPRE_DescribeError(noted, text.data());
  return {FaultKind::numeric, "hypre", text.data()};
}

}  // namespace

static_assert(sizeof(HYPRE_Int) == sizeof(SparseMatrix::StorageIndex));

struct ConjugateGradients::Parts {
  Parts() = default;
  ~Parts() {
    if (solver != nullptr) HYPRE_ParCSRPCGDestroy(solver);
    if (multigrid != nullptr) HYPRE_BoomerAMGDestroy(multigrid);
    if (right != nullptr) HYPRE_IJVectorDestroy(right);
    if (left != nullptr) HYPRE_IJVectorDestroy(left);
    if (matrix != nullptr) HYPRE_IJMatrixDestroy(matrix);
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  void create(const SparseMatrix& values);
  void fill(const SparseMatrix& values);
  void create_solver(const ConjugateGradientsOptions& options);

  int size{};
  double tolerance{};
  std::vector<HYPRE_Int> rows;
  HYPRE_IJMatrix matrix{};
  HYPRE_IJVector left{};
  HYPRE_IJVector right{};
  HYPRE_ParCSRMatrix parallel_matrix{};
  HYPRE_ParVector parallel_left{};
  HYPRE_ParVector parallel_right{};
  HYPRE_Solver solver{};
  HYPRE_Solver multigrid{};
};

void ConjugateGradients::Parts::create(const SparseMatrix& values) {
  size = static_cast<int>(values.rows());
  rows.resize(size);
  std::iota(rows.begin(), rows.end(), 0);
  HYPRE_IJMatrixCreate(MPI_COMM_SELF, 0, size - 1, 0, size - 1, &matrix);
  HYPRE_IJMatrixSetObjectType(matrix, HYPRE_PARCSR);
  std::vector<HYPRE_Int> counts(size);
  for (int row = 0; row < size; ++row) counts[row] = values.outerIndexPtr()[row + 1] - values.outerIndexPtr()[row];
  const std::vector<HYPRE_Int> none(size, 0);
  HYPRE_IJMatrixSetDiagOffdSizes(matrix, counts.data(), none.data());
  fill(values);
  void* object = nullptr;
  HYPRE_IJMatrixGetObject(matrix, &object);
  parallel_matrix = static_cast<HYPRE_ParCSRMatrix>(object);
  left = make_vector(size, parallel_left);
  right = make_vector(size, parallel_right);
}

void ConjugateGradients::Parts::fill(const SparseMatrix& values) {
  assert(values.rows() == size && values.isCompressed());
  HYPRE_IJMatrixInitialize(matrix);
  std::vector<HYPRE_Int> counts(size);
  for (int row = 0; row < size; ++row) counts[row] = values.outerIndexPtr()[row + 1] - values.outerIndexPtr()[row];
  HYPRE_IJMatrixSetValues(matrix, size, counts.data(), rows.data(), values.innerIndexPtr(), values.valuePtr());
  HYPRE_IJMatrixAssemble(matrix);
}

void ConjugateGradients::Parts::create_solver(const ConjugateGradientsOptions& options) {
  tolerance = options.tolerance;
  HYPRE_ParCSRPCGCreate(MPI_COMM_SELF, &solver);
  HYPRE_PCGSetMaxIter(solver, options.most_iterations);
  HYPRE_PCGSetTol(solver, options.tolerance);
  HYPRE_PCGSetTwoNorm(solver, 1);
  HYPRE_BoomerAMGCreate(&multigrid);
  HYPRE_BoomerAMGSetCoarsenType(multigrid, 10);  // HMIS
  HYPRE_BoomerAMGSetInterpType(multigrid, 6);    // extended+i
  HYPRE_BoomerAMGSetPMaxElmts(multigrid, 2);
  // Gauss-Seidel sweeps forwards on the way down and backwards on the way up. The cycle is then symmetric, at half the
  // cost of two sweeps per level and direction.
  HYPRE_BoomerAMGSetCycleRelaxType(multigrid, 13, 1);
  HYPRE_BoomerAMGSetCycleRelaxType(multigrid, 14, 2);
  HYPRE_BoomerAMGSetCycleRelaxType(multigrid, 9, 3);  // elimination on the coarsest
  HYPRE_BoomerAMGSetNumSweeps(multigrid, 1);
  HYPRE_BoomerAMGSetStrongThreshold(multigrid, 0.6);
  HYPRE_BoomerAMGSetTol(multigrid, 0);
  HYPRE_BoomerAMGSetMaxIter(multigrid, 1);
  HYPRE_BoomerAMGSetPrintLevel(multigrid, 0);
  HYPRE_ParCSRPCGSetPrecond(solver, HYPRE_BoomerAMGSolve, HYPRE_BoomerAMGSetup, multigrid);
}

Result<ConjugateGradients> ConjugateGradients::create(SparseMatrix matrix, const ConjugateGradientsOptions& options) {
  start_message_passing();
  matrix.makeCompressed();
  auto parts = std::make_unique<Parts>();
  parts->create(matrix);
  matrix = SparseMatrix();
  parts->create_solver(options);
  HYPRE_ParCSRPCGSetup(parts->solver, parts->parallel_matrix, parts->parallel_right, parts->parallel_left);
  if (const int noted = errors(); noted != 0) return failure(fault(noted));
  return ConjugateGradients(std::move(parts));
}

ConjugateGradients::ConjugateGradients(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
ConjugateGradients::~ConjugateGradients() = default;
ConjugateGradients::ConjugateGradients(ConjugateGradients&&) noexcept = default;
ConjugateGradients& ConjugateGradients::operator=(ConjugateGradients&&) noexcept = default;

auto ConjugateGradients::solve(const Eigen::VectorXd& right, const Eigen::VectorXd& guess) -> Result<Solution> {
  auto& p = *parts_;
  assert(right.size() == p.size && guess.size() == p.size);
  HYPRE_IJVectorSetValues(p.right, p.size, p.rows.data(), right.data());
  HYPRE_IJVectorSetValues(p.left, p.size, p.rows.data(), guess.data());
  HYPRE_ParCSRPCGSolve(p.solver, p.parallel_matrix, p.parallel_right, p.parallel_left);
  const int noted = errors();
  Solution solution;
  HYPRE_PCGGetNumIterations(p.solver, &solution.iterations);
  HYPRE_PCGGetFinalRelativeResidualNorm(p.solver, &solution.relative_residual);
  solution.x.resize(p.size);
  HYPRE_IJVectorGetValues(p.left, p.size, p.rows.data(), solution.x.data());
  if (noted != 0 && noted != HYPRE_ERROR_CONV) return failure(fault(noted));
  if (!(solution.relative_residual <= p.tolerance) || !solution.x.allFinite()) {
    return failure(FaultKind::numeric, "conjugate gradients",
                   fmt::format("relative residual {:.1e} after {} iterations, expected at most {:.1e}",
                               solution.relative_residual, solution.iterations, p.tolerance));
  }
  return solution;
}

auto ConjugateGradients::solve(const Eigen::VectorXd& right) -> Result<Solution> {
  return solve(right, Eigen::VectorXd::Zero(right.size()));
}

Eigen::VectorXd ConjugateGradients::precondition(const Eigen::VectorXd& right) {
  auto& p = *parts_;
  assert(right.size() == p.size);
  Eigen::VectorXd left = Eigen::VectorXd::Zero(p.size);
  HYPRE_IJVectorSetValues(p.right, p.size, p.rows.data(), right.data());
  HYPRE_IJVectorSetValues(p.left, p.size, p.rows.data(), left.data());
  HYPRE_BoomerAMGSolve(p.multigrid, p.parallel_matrix, p.parallel_right, p.parallel_left);
  HYPRE_IJVectorGetValues(p.left, p.size, p.rows.data(), left.data());
  return left;
}

Result<void> ConjugateGradients::replace(SparseMatrix matrix) {
  matrix.makeCompressed();
  parts_->fill(matrix);
  if (const int noted = errors(); noted != 0) return failure(fault(noted));
  return {};
}

}  // namespace gyrotherm::thermal
