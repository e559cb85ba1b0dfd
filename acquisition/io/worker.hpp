/// A thread that makes one instrument's calls, so that a blocking one delays nobody else.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm {

/// Jobs run one after the other; at most one waits. The destructor waits for the job that runs: every instrument's call
/// has an end of its own.
class Worker {
 public:
  Worker() : thread_([this](std::stop_token stop) { serve(stop); }) {}

  /// Hands over a job. Whoever drops the future drops the answer, also one that comes late. The job before must have
  /// begun or been withdrawn.
  template <class Job>
  [[nodiscard]] auto post(Job job) {
    auto task = std::make_shared<std::packaged_task<decltype(job())()>>(std::move(job));
    auto answer = task->get_future();
    enqueue([task] { (*task)(); });
    return answer;
  }

  /// Takes back a job that has not begun; false if it has.
  bool withdraw();

  /// How long the job that runs now has run; zero if none does.
  [[nodiscard]] Duration busy_for();

 private:
  void enqueue(std::function<void()> job);
  void serve(std::stop_token stop);

  std::mutex mutex_;
  std::condition_variable_any posted_;
  std::function<void()> waiting_;
  std::optional<std::chrono::steady_clock::time_point> began_;  ///< the job that runs now
  std::jthread thread_;                                         ///< last: it uses the others
};

}  // namespace gyrotherm
