/// The gyrotherm program: reads the command line, runs one command, ends with its exit code.
#include "app/command.hpp"

namespace gyrotherm {
namespace {

void add_commands(Program& program) {
  add_qualify(program);
  add_run(program);
  add_resume(program);
  add_status(program);
  add_tell(program);
  add_simulate(program);
  add_check(program);
  add_devices(program);
  add_import(program);
  add_export(program);
  add_thermal(program);
  add_train(program);
  add_verify(program);
  add_placement(program);
  add_reduce(program);
  add_compensate(program);
  add_export_model(program);
  add_report(program);
}

}  // namespace
}  // namespace gyrotherm

int main(int argc, char** argv) {
  gyrotherm::Program program(
      "gyrotherm", "gyrotherm runs a gyroscope through a temperature program and makes its bias compensation.");
  gyrotherm::add_commands(program);
  return run(program, argc, argv);
}
