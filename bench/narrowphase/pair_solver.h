// The interface of a library in the narrow-phase bench.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pair_classes.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "trial.h"

namespace tandem::bench {

/// The answer of any library for one pair.
struct Found {
  bool failed = false;         ///< an exception, an error code, or a refusal
  bool collide = false;        ///< Request::contacts: there is a contact
  bool measured = false;       ///< signed_distance is set
  double signed_distance = 0;  ///< Request::contacts: minus the depth of the deepest contact
  Vec3 normal = Vec3::Zero();  ///< unit, from A to B; zero: none given
};

/// The question to all contestants. The pairs outlive it.
struct Question {
  std::span<const reference::PosedPair> pairs;
  Request request = Request::collide;
  std::size_t tracks = 0;  ///< > 0: pair i + tracks is pair i one time step later
};

/// A library set up for a question as a careful user would do it: its shapes are built, and no query allocates but
/// within the library.
class PairSolver {
 public:
  virtual ~PairSolver() = default;
  /// Answers every pair of the question, in order; this is timed. Pairs at which the library aborts are left out.
  virtual void answer(std::span<Found> out) = 0;
  virtual void answer_one(std::size_t pair) = 0;
  /// Declares pairs with a nonzero mark failures, which are not asked again. One mark a pair, or none.
  void leave_out(std::vector<char> pairs) { left_out_ = std::move(pairs); }
  std::size_t left_out() const { return static_cast<std::size_t>(std::count(left_out_.begin(), left_out_.end(), 1)); }

 protected:
  bool is_left_out(std::size_t pair) const { return !left_out_.empty() && left_out_[pair] != 0; }
  void leave_out(std::size_t pair, std::size_t pairs) {
    left_out_.resize(pairs, 0);
    left_out_[pair] = 1;
  }

 private:
  std::vector<char> left_out_;
};

struct Entrant {
  std::string name;
  /// Null if the library has no answer to the question.
  std::function<std::unique_ptr<PairSolver>(const Question&)> enter;
};

/// The contestant that is given all pairs of a question together.
inline constexpr std::string_view several_at_once = "tandem, several at once";

std::vector<Entrant> tandem_entrants();
std::vector<Entrant> fcl_entrants();
std::vector<Entrant> ccd_entrants();
std::vector<Entrant> bullet_entrants();

/// A solver by a function of the pair's number, which may throw.
template <typename One>
std::unique_ptr<PairSolver> each_pair(One one) {
  class EachPair final : public PairSolver {
   public:
    explicit EachPair(One&& one) : one_(std::move(one)) {}
    void answer(std::span<Found> out) override {
      next_ = 0;
      while (!attempt([&] {
        for (; next_ < out.size(); ++next_) out[next_] = is_left_out(next_) ? Found{.failed = true} : guarded(next_);
      }))
        leave_out(next_, out.size());
    }
    void answer_one(std::size_t pair) override { guarded(pair); }

   private:
    Found guarded(std::size_t i) {
      try {
        return one_(i);
      } catch (const std::exception&) {
        return {.failed = true};
      }
    }

    One one_;
    std::size_t next_ = 0;  ///< a member, so that an abort does not lose it
  };
  return std::make_unique<EachPair>(std::move(one));
}

}  // namespace tandem::bench
