/// For threads beside the main one.
#pragma once

#include <csignal>

namespace gyrotherm {

/// From now on the calling thread gets no signals: they belong to the main thread, and would end a poll of the
/// instruments' libraries as an unplugged device does.
inline void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace gyrotherm
