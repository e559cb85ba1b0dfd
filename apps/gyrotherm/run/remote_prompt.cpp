// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/remote_prompt.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "acquisition/record/status_file.hpp"
#include "apps/console/interrupt.hpp"
#include "core/deadline.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::app {
namespace {

constexpr int kPollMs = 200;
/// Interval at which the status file is renewed, shorter than record::kSilentAfter.
constexpr Duration kRenewEvery = std::chrono::seconds(1);

constexpr const char* kNotStarted =
    "the run has not started; \"resume\" with a serial number answers the question, \"stop\" ends the program";

class SocketPrompt final : public RemotePrompt {
 public:
  SocketPrompt(Console& console, control::ControlSocket socket, const std::string& record, bool simulated)
      : console_(console), socket_(std::move(socket)) {
    status_.path = record;
    status_.pid = ::getpid();
    status_.being_written = true;
    status_.simulated = simulated;
    status_.overview.state = RunState::held;
  }
  ~SocketPrompt() override {
    std::error_code error;
    std::filesystem::remove(record::status_path(status_.path), error);
  }
  SocketPrompt(const SocketPrompt&) = delete;
  SocketPrompt& operator=(const SocketPrompt&) = delete;

  Result<void> ask(const std::string& question, const Acceptor& accept) override {
    status_.overview.cause = question;
    console_.print_message(fmt::format("{}: {}", status_.path, question));
    bool answered = false;
    std::string stopped_by;
    const auto answer = [&](const control::ControlRequest& request, const std::string& who) {
      const auto reply = carry_out(request, who, accept, answered, stopped_by);
      console_.print_message(fmt::format("{} by {}: {}", reply.done ? "answer" : "refused answer", who, reply.text));
      return reply;
    };
    while (!answered && stopped_by.empty()) {
      if (interrupted()) return failure(FaultKind::interrupted, status_.path, "stopped before the run was started");
      if (auto shown = write_status(status_); !shown) return shown;
      for (const Deadline renewal(kRenewEvery);
           !answered && stopped_by.empty() && !interrupted() && !renewal.has_passed();) {
        pollfd waiting{socket_.descriptor(), POLLIN, 0};
        (void)::poll(&waiting, 1, kPollMs);
        socket_.listen(answer);
      }
    }
    if (stopped_by.empty()) return {};
    return failure(FaultKind::interrupted, status_.path,
                   fmt::format("stopped by {} before the run was started", stopped_by));
  }

 private:
  /// Carries out one request. A client whose message follows an accepted answer is referred to the next question.
  static control::ControlAnswer carry_out(const control::ControlRequest& request, const std::string& who,
                                          const Acceptor& accept, bool& answered, std::string& stopped_by) {
    using control::OperatorCommand;
    if (request.command == OperatorCommand::stop || request.command == OperatorCommand::abort) {
      stopped_by = who;
      return {.done = true, .text = "the run is not started"};
    }
    if (request.command != OperatorCommand::resume) return {.done = false, .text = kNotStarted};
    if (answered) return {.done = false, .text = "another operator has answered; read the next question"};
    const auto accepted = accept(request.note);
    if (!accepted) return {.done = false, .text = accepted.error().what};
    answered = true;
    return {.done = true, .text = *accepted};
  }

  Console& console_;
  control::ControlSocket socket_;
  record::RunStatus status_;
};

}  // namespace

Result<std::unique_ptr<RemotePrompt>> RemotePrompt::open(Console& console, const std::string& record, bool simulated) {
  if (record::read_fresh_status(record))
    return failure(FaultKind::refused, record, "another program is starting a run with this record");
  const auto folder = std::filesystem::path(record).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return failure(FaultKind::storage, folder.string(), "cannot be created: " + error.message());
  auto socket = control::ControlSocket::open(record);
  if (!socket) return failure(socket.error());
  watch_for_interrupts(SecondInterrupt::ends);
  return std::make_unique<SocketPrompt>(console, std::move(*socket), record, simulated);
}

}  // namespace gyrotherm::app
