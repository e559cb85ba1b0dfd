// SPDX-License-Identifier: Apache-2.0
/// Runs programs and reads their files, for the tests of gyrotherm-pdf.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace gyrotherm::pdf {

struct Ran {
  int exit_code = -1;
  std::string out;  ///< stdout and stderr
};

/// Runs a command line in a shell and waits for its end.
inline Ran shell(const std::string& command) {
  Ran ran;
  FILE* pipe = ::popen(("{ " + command + "; } 2>&1").c_str(), "r");
  if (pipe == nullptr) return ran;
  std::array<char, 4096> piece{};
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;)
    ran.out.append(piece.data(), size);
  const int status = ::pclose(pipe);
  ran.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ran;
}

inline bool installed(const std::string& program) { return shell("command -v " + program).exit_code == 0; }

inline std::string content_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace gyrotherm::pdf
