#include "thermal/message_passing.hpp"

#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <HYPRE_utilities.h>
#include <mpi.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <optional>
#include <string>

namespace gyrotherm {
namespace {

/// Keeps every signal's handler and puts it back.
class SignalHandlers {
 public:
  SignalHandlers() {
    for (int s = 1; s < NSIG; ++s) kept_[s] = sigaction(s, nullptr, &handlers_[s]) == 0;
  }
  ~SignalHandlers() {
    for (int s = 1; s < NSIG; ++s)
      if (kept_[s]) sigaction(s, &handlers_[s], nullptr);
  }
  SignalHandlers(const SignalHandlers&) = delete;
  SignalHandlers& operator=(const SignalHandlers&) = delete;

 private:
  std::array<struct sigaction, NSIG> handlers_{};
  std::array<bool, NSIG> kept_{};
};

/// An environment variable for as long as this lives; one that is set already is left alone.
class Setting {
 public:
  Setting(const char* name, const char* value) : name_(name), ours_(std::getenv(name) == nullptr) {
    if (ours_) setenv(name, value, 1);
  }
  ~Setting() {
    if (ours_) unsetenv(name_);
  }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  bool ours_;
};

class Session {
 public:
  Session() : process_(getpid()) {
    int running = 0;
    MPI_Initialized(&running);
    if (running == 0) {
      const SignalHandlers handlers;
      const Setting alone("OMPI_MCA_ess_singleton_isolated", "1");  // no daemon, which would want a network
      // None of the folders that all processes of a user share: who ends removes them while another begins, and fails.
      const Setting folders("OMPI_MCA_orte_create_session_dirs", "0");
      const Setting transport("OMPI_MCA_btl", "self");
      const Setting messages("OMPI_MCA_pml", "ob1");
      MPI_Init(nullptr, nullptr);
      ours_ = true;
    }
    HYPRE_Init();
  }
  ~Session() {
    if (!ours_ || getpid() != process_) return;  // a forked child leaves it alone
    const SignalHandlers handlers;
    HYPRE_Finalize();
    int ended = 0;
    MPI_Finalized(&ended);
    if (ended == 0) MPI_Finalize();
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  pid_t process_;
  bool ours_ = false;
};

}  // namespace

void start_message_passing() { static const Session session; }

}  // namespace gyrotherm
