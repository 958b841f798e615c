// A timeline of steps for trace viewers.
#pragma once
#include <chrono>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace tandem {

/// Slices and counters of steps for a trace viewer, a lane a thread. Recording a slice looks the thread's lane up under
/// a lock (some 50 ns, against tasks of 10 us) and appends to memory that is the thread's own.
class Timeline {
 public:
  using Clock = std::chrono::steady_clock;

  struct Slice {
    std::string_view name;  ///< a literal
    Clock::time_point begin, end;
    std::uint64_t step = 0;
    std::uint64_t id = 0;  ///< block or batch
    std::uint64_t pairs = 0;
    bool heavy = false;  ///< pairs that cost far more than others
  };
  struct Lane {
    std::thread::id thread;
    std::vector<Slice> slices;
  };
  struct Counter {
    std::string_view name;
    Clock::time_point at;
    double value = 0;
  };
  struct Note {
    Clock::time_point at;
    std::string text;
  };

  Timeline() : start_(Clock::now()) {}
  /// The lane of the calling thread; the reference stays valid.
  Lane& lane();
  /// Not while a step runs, like write().
  template <class Visit>
  void each_slice(Visit&& visit) const {
    for (const auto& lane : lanes_)
      for (const Slice& slice : lane->slices) visit(slice);
  }
  /// The number of slices recorded. Not while a step runs.
  std::size_t slices() const;
  void count(std::string_view name, double value);
  void note(std::string text);

  /// Writes Chrome's trace-event format, one JSON object (opens in Perfetto). Not while a step runs.
  void write(std::ostream& out) const;

 private:
  Clock::time_point start_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::vector<Counter> counters_;
  std::vector<Note> notes_;
};

}  // namespace tandem
