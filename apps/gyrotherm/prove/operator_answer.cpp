// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/prove/operator_answer.hpp"

#include <termios.h>
#include <unistd.h>

#include <string>

namespace gyrotherm::app {

void discard_typed_input(int input) {
  if (::isatty(input) == 1) ::tcflush(input, TCIFLUSH);
}

bool read_confirmation(int input) {
  std::string answer;
  for (char byte = 0; ::read(input, &byte, 1) == 1; answer += byte)
    if (byte == '\n') return answer.find_first_not_of(" \t\r") == std::string::npos;
  return false;
}

}  // namespace gyrotherm::app
