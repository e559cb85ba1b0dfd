// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/conjugate_gradients.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <map>

#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

SparseMatrix conduction(double film) {
  const auto mesh = box_of(GyroPart::block, even_lines(0.1, 8), even_lines(0.1, 8), even_lines(0.05, 5), {0, 4});
  return conduction_matrix(uniform_model({2000, 500, 1.5}), mesh, {0, 0, 0, film});
}

void expect_solves(ConjugateGradients& solver, const SparseMatrix& matrix, unsigned seed) {
  const auto right = random_vector(matrix.rows(), seed);
  const auto solution = solver.solve(right);
  ASSERT_TRUE(solution) << text(solution.error());
  EXPECT_LT((matrix * solution->x - right).norm(), 1.1e-10 * right.norm()) << "seed " << seed;
  EXPECT_GT(solution->iterations, 0);
}

TEST(ConjugateGradients, SolveConsecutiveRightHandSides) {
  const auto matrix = conduction(5);
  auto solver = ConjugateGradients::create(matrix);
  ASSERT_TRUE(solver) << text(solver.error());
  for (unsigned seed = 1; seed <= 5; ++seed) expect_solves(*solver, matrix, seed);
}

TEST(ConjugateGradients, SupportTwoInstances) {
  const auto one = conduction(5);
  const auto other = conduction(50);
  auto first = ConjugateGradients::create(one);
  auto second = ConjugateGradients::create(other);
  ASSERT_TRUE(first && second);
  expect_solves(*first, one, 1);
  expect_solves(*second, other, 2);
  expect_solves(*first, one, 3);
}

TEST(ConjugateGradients, AcceptReplacedMatrix) {
  auto solver = ConjugateGradients::create(conduction(5));
  ASSERT_TRUE(solver);
  const auto changed = conduction(6);
  ASSERT_TRUE(solver->replace(changed));
  expect_solves(*solver, changed, 7);
}

TEST(ConjugateGradients, NeedNoIterationFromSolution) {
  const auto matrix = conduction(5);
  auto solver = ConjugateGradients::create(matrix);
  ASSERT_TRUE(solver);
  const auto right = random_vector(matrix.rows(), 3);
  const auto first = solver->solve(right);
  ASSERT_TRUE(first);
  const auto second = solver->solve(right, first->x);
  ASSERT_TRUE(second);
  EXPECT_LE(second->iterations, 1);
}

TEST(ConjugateGradients, ApplySymmetricCycleNearInverse) {
  const auto matrix = conduction(5);
  auto solver = ConjugateGradients::create(matrix);
  ASSERT_TRUE(solver);
  const auto a = random_vector(matrix.rows(), 1);
  const auto b = random_vector(matrix.rows(), 2);
  const auto of_a = solver->precondition(a);
  const auto of_b = solver->precondition(b);
  EXPECT_NEAR(b.dot(of_a) / a.dot(of_b), 1, 1e-10);
  EXPECT_LT((matrix * of_a - a).norm(), 0.5 * a.norm());
}

TEST(ConjugateGradients, FailWhenToleranceIsNotReached) {
  auto solver = ConjugateGradients::create(conduction(5), {.tolerance = 1e-10, .most_iterations = 2});
  ASSERT_TRUE(solver);
  const auto solution = solver->solve(random_vector(conduction(5).rows(), 1));
  ASSERT_FALSE(solution);
  EXPECT_EQ(solution.error().kind, FaultKind::numeric);
  EXPECT_NE(solution.error().what.find("after 2 iterations"), std::string::npos) << solution.error().what;
}

TEST(ConjugateGradients, RestoreSignalHandlers) {
  const auto handlers = [] {
    std::map<int, void (*)(int)> all;
    for (const int s : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGINT, SIGTERM, SIGUSR1, SIGCHLD}) {
      struct sigaction action {};
      EXPECT_EQ(sigaction(s, nullptr, &action), 0);
      all[s] = action.sa_handler;
    }
    return all;
  };
  const auto before = handlers();
  const auto solver = ConjugateGradients::create(conduction(5));
  ASSERT_TRUE(solver);
  EXPECT_EQ(handlers(), before);
}

}  // namespace
}  // namespace gyrotherm::thermal
