// SPDX-License-Identifier: Apache-2.0
/// A disk that hangs, for a program that is started with this in LD_PRELOAD: as long as the file is there that
/// GYROTHERM_HANG names, no sync comes back.
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>

namespace {

void wait_while_hanging() {
  constexpr unsigned kLookUs = 10'000;
  const char* file = std::getenv("GYROTHERM_HANG");
  while (file != nullptr && ::access(file, F_OK) == 0) ::usleep(kLookUs);
}

}  // namespace

extern "C" int fsync(int file) {
  wait_while_hanging();
  return static_cast<int>(::syscall(SYS_fsync, file));
}

extern "C" int fdatasync(int file) {
  wait_while_hanging();
  return static_cast<int>(::syscall(SYS_fdatasync, file));
}
