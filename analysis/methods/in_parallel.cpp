#include "analysis/methods/in_parallel.hpp"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace gyrotherm {

bool in_parallel(std::size_t count, int threads, std::string_view stage, const ProgressSink& progress,
                 const std::function<void(std::size_t)>& work) {
  const int available = tbb::info::default_concurrency();
  tbb::task_arena arena(threads == 0 ? available : std::min(threads, available));
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> stopped = false;
  const auto ask = [&] { return keep_going(progress, stage, static_cast<double>(done) / static_cast<double>(count)); };
  arena.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, count,
        [&](std::size_t index) {
          if (stopped) return;
          work(index);
          ++done;
          if (std::this_thread::get_id() == caller && !ask()) stopped = true;
        },
        tbb::simple_partitioner{});
  });
  return !stopped && ask();
}

}  // namespace gyrotherm
