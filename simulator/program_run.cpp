#include "simulator/program_run.hpp"

#include <cassert>
#include <chrono>
#include <utility>

namespace gyrotherm {

void ProgramRun::start(ChamberProgram program, int first) {
  program_ = std::move(program);
  enter(static_cast<std::size_t>(first < 0 ? 0 : first));
}

void ProgramRun::enter(std::size_t step) {
  step_ = step;
  elapsed_ = {};
  if (step_ >= program_.steps.size())
    stage_ = Stage::done;
  else
    stage_ = program_.steps[step_].kind == StepKind::ramp ? Stage::ramping : Stage::soaking;
}

void ProgramRun::hold() {
  if (runs()) stage_ = Stage::held;
}

void ProgramRun::resume() {
  if (stage_ == Stage::held) stage_ = program_.steps[step_].kind == StepKind::ramp ? Stage::ramping : Stage::soaking;
}

Celsius ProgramRun::next_set_point(Celsius air) {
  assert(runs());
  while (runs() && elapsed_ >= program_.steps[step_].duration) enter(step_ + 1);
  if (!runs()) return program_.steps.back().target;
  const auto& step = program_.steps[step_];
  const double part = to_seconds(elapsed_) / to_seconds(step.duration);
  const auto set_point = step.start + (step.target - step.start) * part;
  const bool waits = step.guaranteed_soak && abs(air - step.target) > program_.soak_band;
  if (!waits) elapsed_ += std::chrono::seconds(1);
  return set_point;
}

}  // namespace gyrotherm
