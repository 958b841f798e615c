// Colours the pairs of bodies that several ranks move, in the order of one rank.
#include "shared_bodies.h"

#include <algorithm>
#include <utility>

#include "records.h"

namespace tandem::mpi {

void SharedBodies::begin(std::span<const OwnPair> pairs) {
  pairs_ = pairs;
  uses_.clear();
  shared_.clear();
  bytes_ = messages_ = 0;
}

void SharedBodies::write_uses(Outbox& outbox) const {
  for (const OwnPair& pair : pairs_)
    for (const std::size_t k : {0u, 1u}) {
      if (!pair.moves[k] || bodies_.owns(pair.body[k])) continue;
      Message& message = outbox.to(bodies_.owner(pair.body[k]));
      message.put(ResponseItem::use);
      message.put(bodies_.id(pair.body[k]));
      message.put(pair.ids);
    }
}

void SharedBodies::read_use(Message& message, int rank) {
  const auto id = message.take<GlobalId>();
  uses_.push_back({bodies_.place(id).value(), message.take<IdPair>(), rank});
}

void SharedBodies::write_orders(Outbox& outbox) {
  std::vector<std::uint8_t> is_used(bodies_.scene().indices());
  for (const Use& use : uses_) is_used[use.body] = 1;
  if (!uses_.empty())
    for (const OwnPair& pair : pairs_)
      for (const std::size_t k : {0u, 1u})
        if (pair.moves[k] && is_used[pair.body[k]] != 0)
          uses_.push_back({pair.body[k], pair.ids, communicator_.rank()});
  std::sort(uses_.begin(), uses_.end());
  for (auto first = uses_.begin(); first != uses_.end();) {
    const auto end = std::find_if(first, uses_.end(), [&](const Use& use) { return use.body != first->body; });
    SharedBody& body = shared_.emplace_back();
    body.id = bodies_.id(first->body);
    body.index = first->body;
    body.owner = communicator_.rank();
    for (; first != end; ++first) body.ranks.push_back(first->rank);
    std::vector<int> receivers = body.ranks;
    std::sort(receivers.begin(), receivers.end());
    receivers.erase(std::unique(receivers.begin(), receivers.end()), receivers.end());
    std::erase(receivers, body.owner);
    for (const int rank : receivers) {
      Message& message = outbox.to(rank);
      message.put(ResponseItem::order);
      message.put(body.id);
      message.put(static_cast<std::uint32_t>(body.ranks.size()));
      for (const int one : body.ranks) message.put(one);
    }
  }
}

void SharedBodies::read_order(Message& message, int owner) {
  SharedBody& body = shared_.emplace_back();
  body.id = message.take<GlobalId>();
  body.index = bodies_.place(body.id).value();
  body.owner = owner;
  for (auto count = message.take<std::uint32_t>(); count > 0; --count) body.ranks.push_back(message.take<int>());
}

/// Links each pair to the pairs that wait for it.
void SharedBodies::link_pairs() {
  const std::size_t indices = bodies_.scene().indices();
  std::sort(shared_.begin(), shared_.end(), [](const SharedBody& x, const SharedBody& y) { return x.id < y.id; });
  shared_of_.assign(indices, none);
  for (std::uint32_t s = 0; s < shared_.size(); ++s) shared_of_[shared_[s].index] = s;
  next_of_.assign(indices, none);
  next_side_.assign(2 * pairs_.size(), none);
  for (std::size_t p = pairs_.size(); p-- > 0;)
    for (const std::uint32_t k : {0u, 1u})
      if (pairs_[p].moves[k]) {
        const auto side = static_cast<std::uint32_t>(2 * p + k);
        next_side_[side] = std::exchange(next_of_[pairs_[p].body[k]], side);
      }
  waits_.assign(pairs_.size(), 0);
  ready_.clear();
  for (std::uint32_t p = 0; p < pairs_.size(); ++p) {
    for (const std::uint32_t k : {0u, 1u}) {
      const std::uint32_t body = pairs_[p].body[k];
      if (!pairs_[p].moves[k]) continue;
      const std::uint32_t s = shared_of_[body];
      const bool first = next_of_[body] == 2 * p + k && (s == none || shared_[s].ranks[0] == communicator_.rank());
      if (!first) ++waits_[p];
    }
    if (waits_[p] == 0) ready_.push_back(p);
  }
}

/// After a pair got its colour: the body's next pair on this rank no longer waits for it.
void SharedBodies::release(std::uint32_t side) {
  if (side != none && --waits_[side / 2] == 0) ready_.push_back(side / 2);
}

/// Sends the body's colours to the rank of its next pair; after the last one to all.
void SharedBodies::pass_on(SharedBody& body) {
  const std::size_t known = body.colours.size();
  const bool complete = known == body.ranks.size();
  std::vector<int> receivers;
  if (complete) {
    ++complete_;
    receivers = body.ranks;
    receivers.push_back(body.owner);
    std::sort(receivers.begin(), receivers.end());
    receivers.erase(std::unique(receivers.begin(), receivers.end()), receivers.end());
    std::erase(receivers, communicator_.rank());
  } else if (body.ranks[known] == communicator_.rank()) {
    return release(next_of_[body.index]);
  } else {
    receivers.push_back(body.ranks[known]);
  }
  for (const int rank : receivers) {
    Message& message = outgoing_[static_cast<std::size_t>(rank)];
    message.put(body.id);
    message.put(static_cast<std::uint32_t>(known));
    for (const std::uint32_t colour : body.colours) message.put(colour);
  }
}

void SharedBodies::colour_ready(std::vector<std::uint32_t>& colours) {
  constexpr TakenColours nothing;
  while (!ready_.empty()) {
    const std::uint32_t p = ready_.back();
    ready_.pop_back();
    const OwnPair& pair = pairs_[p];
    const auto taken = [&](std::size_t k) { return pair.moves[k] ? taken_[pair.body[k]] : nothing; };
    const std::uint32_t colour = TakenColours::first_free(taken(0), taken(1));
    colours[pair.found] = colour;
    ++coloured_;
    for (const std::uint32_t k : {0u, 1u}) {
      if (!pair.moves[k]) continue;
      const std::uint32_t body = pair.body[k], s = shared_of_[body];
      taken_[body].take(colour);
      next_of_[body] = next_side_[2 * p + k];
      if (s == none) {
        release(next_of_[body]);
      } else {
        shared_[s].colours.push_back(colour);
        pass_on(shared_[s]);
      }
    }
  }
}

void SharedBodies::take(Message& message) {
  while (!message.done()) {
    const std::uint32_t index = bodies_.place(message.take<GlobalId>()).value();
    SharedBody& body = shared_[shared_of_[index]];
    const auto known = message.take<std::uint32_t>();
    for (std::uint32_t k = 0; k < known; ++k) {
      const auto colour = message.take<std::uint32_t>();
      if (k < body.colours.size()) continue;
      body.colours.push_back(colour);
      taken_[index].take(colour);
    }
    if (known == body.ranks.size())
      ++complete_;
    else
      release(next_of_[index]);
  }
}

void SharedBodies::give_colours(std::vector<std::uint32_t>& colours) {
  link_pairs();
  taken_.assign(bodies_.scene().indices(), {});
  coloured_ = complete_ = 0;
  outgoing_.resize(static_cast<std::size_t>(communicator_.ranks()));
  while (true) {
    colour_ready(colours);
    for (int rank = 0; rank < communicator_.ranks(); ++rank) {
      Message& message = outgoing_[static_cast<std::size_t>(rank)];
      if (message.empty()) continue;
      bytes_ += message.size();
      ++messages_;
      communicator_.post(Communicator::Topic::colours, std::exchange(message, {}), rank);
    }
    if (coloured_ == pairs_.size() && complete_ == shared_.size()) break;
    RankMessage message = communicator_.await_any(Communicator::Topic::colours);
    take(message.content);
  }
  communicator_.settle();
}

}  // namespace tandem::mpi
