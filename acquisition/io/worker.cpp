#include "acquisition/io/worker.hpp"

#include <cassert>

#include "core/process.hpp"

namespace gyrotherm {

void Worker::enqueue(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    assert(!waiting_ && "the job before has neither begun nor been withdrawn");
    waiting_ = std::move(job);
  }
  posted_.notify_one();
}

bool Worker::withdraw() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, nullptr) != nullptr;
}

Duration Worker::busy_for() {
  const std::lock_guard lock(mutex_);
  return began_ ? Duration(std::chrono::steady_clock::now() - *began_) : Duration{};
}

void Worker::serve(std::stop_token stop) {
  block_signals();
  for (;;) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      if (!posted_.wait(lock, stop, [this] { return waiting_ != nullptr; })) return;
      job = std::exchange(waiting_, nullptr);
      began_ = std::chrono::steady_clock::now();
    }
    job();
    const std::lock_guard lock(mutex_);
    began_.reset();
  }
}

}  // namespace gyrotherm
