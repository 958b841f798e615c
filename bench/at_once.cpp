// Threads that begin the same job at the same time.
#include "at_once.h"

namespace tandem::bench {

AtOnce::AtOnce(int copies) : copies_(copies) {
  for (int i = 1; i < copies; ++i)
    others_.emplace_back([this, i] {
      for (std::uint32_t seen = 0;;) {
        turn_.wait(seen, std::memory_order_acquire);
        seen = turn_.load(std::memory_order_acquire);
        if (leaving_.load(std::memory_order_relaxed)) return;
        meet();
        (*job_)(i);
        left_.fetch_sub(1, std::memory_order_release);
      }
    });
}

AtOnce::~AtOnce() {
  leaving_.store(true, std::memory_order_relaxed);
  turn_.fetch_add(1, std::memory_order_release);
  turn_.notify_all();
}

void AtOnce::run(const std::function<void(int)>& job) {
  job_ = &job;
  awake_.store(0, std::memory_order_relaxed);
  left_.store(copies_ - 1, std::memory_order_relaxed);
  turn_.fetch_add(1, std::memory_order_release);
  turn_.notify_all();
  meet();
  job(0);
  while (left_.load(std::memory_order_acquire) != 0) std::this_thread::yield();
}

void AtOnce::meet() {
  awake_.fetch_add(1, std::memory_order_acq_rel);
  while (awake_.load(std::memory_order_acquire) < copies_) std::this_thread::yield();
}

std::string copies_name(int copies) { return std::to_string(copies) + " copies"; }

}  // namespace tandem::bench
