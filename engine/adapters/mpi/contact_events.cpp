// Pairs that began or ceased to touch, across ranks.
#include "tandem/mpi/contact_events.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "communicator.h"
#include "home.h"
#include "pipeline_impl.h"

namespace tandem::mpi {
namespace {

/// Removes the elements that both lists have: a pair that moved from one rank to another continues to touch.
void cancel(std::vector<IdPair>& x, std::vector<IdPair>& y) {
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  std::vector<IdPair> only_x, only_y;
  std::set_difference(x.begin(), x.end(), y.begin(), y.end(), std::back_inserter(only_x));
  std::set_difference(y.begin(), y.end(), x.begin(), x.end(), std::back_inserter(only_y));
  x.swap(only_x);
  y.swap(only_y);
}

}  // namespace

void ContactEvents::update(const Pipeline& pipeline) {
  Communicator& communicator = pipeline.impl_->communicator;
  std::swap(touching_, before_);
  touching_.clear();
  for (const PairResult& pair : pipeline.contacts().pairs)
    if (pair.answer.collide) touching_.push_back({pipeline.id(pair.a), pipeline.id(pair.b)});
  std::sort(touching_.begin(), touching_.end());
  began_ = touching_;
  ended_ = before_;
  cancel(began_, ended_);
  const int ranks = communicator.ranks();
  if (ranks == 1) return;
  Outbox outbox(ranks);
  for (const bool begins : {true, false})
    for (const IdPair& pair : begins ? began_ : ended_) {
      Message& message = outbox.to(home(pair, ranks));
      message.put(pair);
      message.put(begins);
    }
  std::vector<RankMessage> received = communicator.exchange(outbox);
  began_.clear();
  ended_.clear();
  for (RankMessage& message : received)
    while (!message.content.done()) {
      const auto pair = message.content.take<IdPair>();
      (message.content.take<bool>() ? began_ : ended_).push_back(pair);
    }
  cancel(began_, ended_);
}

}  // namespace tandem::mpi
