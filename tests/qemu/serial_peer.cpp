// SPDX-License-Identifier: Apache-2.0
/// Runs inside the emulated machine: a Lake Shore 218 on a UART at 9600 7O1, implemented with system calls only.
///   serial_peer /dev/ttyS2
#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace {

std::string answer_to(const std::string& question) {
  if (question == "*IDN?") return "LSCI,MODEL218E,21EA4F,042109\r\n";
  if (question == "CRDG? 0") return "+20.500,+21.500,+22.500,+23.500,+24.500,+25.500,+26.500,+27.500\r\n";
  return "";
}

}  // namespace

int main(int, char** arguments) {
  const int port = open(arguments[1], O_RDWR | O_NOCTTY);
  termios settings{};
  if (port < 0 || tcgetattr(port, &settings) != 0) return std::perror(arguments[1]), 1;
  cfmakeraw(&settings);
  cfsetspeed(&settings, B9600);
  settings.c_cflag = (settings.c_cflag & ~static_cast<tcflag_t>(CSIZE)) | CS7 | PARENB | PARODD | CLOCAL | CREAD;
  if (tcsetattr(port, TCSANOW, &settings) != 0) std::perror("tcsetattr");
  std::string question;
  for (char byte = 0; read(port, &byte, 1) == 1;) {
    if (byte != '\n') {
      if (byte != '\r') question += byte;
      continue;
    }
    const auto answer = answer_to(question);
    question.clear();
    if (write(port, answer.data(), answer.size()) < 0) return 1;
  }
}
