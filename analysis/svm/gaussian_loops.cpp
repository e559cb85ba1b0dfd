#include "analysis/svm/gaussian_loops.hpp"

#include "analysis/svm/gaussian_loops_body.hpp"

namespace gyrotherm {
namespace {

// Two doubles to a register: SSE2, Neon.
GYROTHERM_GAUSSIAN_LOOPS(PlainLanes<16>);

#if defined(__x86_64__)
bool has_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2");
}
bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
bool has_avx2() { return false; }
bool has_avx512() { return false; }
#endif

}  // namespace

std::vector<const GaussianLoops*> all_gaussian_loops() {
  std::vector<const GaussianLoops*> all;
  if (has_avx512() && gaussian_loops_avx512() != nullptr) all.push_back(gaussian_loops_avx512());
  if (has_avx2() && gaussian_loops_avx2() != nullptr) all.push_back(gaussian_loops_avx2());
  all.push_back(&kLoops);
  return all;
}

const GaussianLoops& gaussian_loops() {
  static const GaussianLoops& best = *all_gaussian_loops().front();
  return best;
}

}  // namespace gyrotherm
