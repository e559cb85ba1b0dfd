/// A virtual controller that carries out a program of its own: set points, one a second.
#pragma once

#include "drivers/chamber/program.hpp"

namespace gyrotherm {

class ProgramRun {
 public:
  enum class Stage { none, ramping, soaking, held, done };

  /// From the step `first` (from 0) on; a program without it is done at once.
  void start(ChamberProgram program, int first);
  void hold();
  void resume();
  void end() { stage_ = Stage::none; }

  [[nodiscard]] Stage stage() const { return stage_; }
  [[nodiscard]] bool runs() const { return stage_ == Stage::ramping || stage_ == Stage::soaking; }
  [[nodiscard]] int step() const { return static_cast<int>(step_); }  ///< from 0
  [[nodiscard]] const ChamberProgram& program() const { return program_; }

  /// The set point of the second that begins now; only while it runs. Then that second is over, unless a guaranteed
  /// soak waits for the air.
  [[nodiscard]] Celsius next_set_point(Celsius air);

 private:
  void enter(std::size_t step);

  ChamberProgram program_;
  std::size_t step_{};
  Duration elapsed_{};
  Stage stage_ = Stage::none;
};

}  // namespace gyrotherm
