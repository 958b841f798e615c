// Messages between ranks: sparse exchanges, sums, and waiting with a time limit.
#include "communicator.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace tandem::mpi {
namespace {

// A message is cut into pieces of this size, since MPI counts in int.
constexpr std::size_t most_bytes = std::size_t{1} << 28;

constexpr int rounds = 2;  // successive exchanges of one kind may overlap between ranks; each kind has its own tags

constexpr int value_tag = 2 * rounds;

int tag_of(Communicator::Topic topic) { return value_tag + 1 + static_cast<int>(topic); }

void combine_two(void* given, void* total, int* count, MPI_Datatype*) {
  const auto* const from = static_cast<const Communicator::Totals*>(given);
  auto* const into = static_cast<Communicator::Totals*>(total);
  for (int k = 0; k < *count; ++k) {
    for (std::size_t i = 0; i < into[k].sums.size(); ++i) into[k].sums[i] += from[k].sums[i];
    for (std::size_t i = 0; i < into[k].largest.size(); ++i)
      into[k].largest[i] = std::max(into[k].largest[i], from[k].largest[i]);
  }
}

}  // namespace

Communicator::Communicator(MPI_Comm of, double patience) : patience_(patience) {
  MPI_Comm_dup(of, &comm_);
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &ranks_);
  static_assert(std::is_trivially_copyable_v<Totals>);
  MPI_Type_contiguous(sizeof(Totals), MPI_BYTE, &totals_type_);
  MPI_Type_commit(&totals_type_);
  MPI_Op_create(combine_two, 1, &totals_op_);
}

Communicator::~Communicator() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized != 0) return;
  MPI_Op_free(&totals_op_);
  MPI_Type_free(&totals_type_);
  MPI_Comm_free(&comm_);
}

void Communicator::abort(const std::string& cause) const {
  std::fprintf(stderr, "tandem::mpi: rank %d, step %llu: %s\n", rank_, static_cast<unsigned long long>(step_),
               cause.c_str());
  std::fflush(stderr);
  MPI_Abort(comm_, 1);
  std::abort();  // not reached: MPI_Abort is not declared [[noreturn]]
}

void Communicator::abort_for_exception() const {
  try {
    throw;
  } catch (const std::exception& error) {
    abort(error.what());
  } catch (...) {
    abort("what was thrown is no std::exception");
  }
}

template <class Done>
void Communicator::until(const Done& done, const char* what) const {
  using Clock = std::chrono::steady_clock;
  const auto begin = patience_ > 0 ? Clock::now() : Clock::time_point{};
  while (!done()) {
    std::this_thread::yield();  // ranks may share a core
    if (patience_ > 0 && std::chrono::duration<double>(Clock::now() - begin).count() > patience_)
      abort(std::string("another rank was waited for longer than ") + std::to_string(patience_) + " s, in " + what);
  }
}

void Communicator::wait(std::span<MPI_Request> requests, const char* what) const {
  until(
      [&] {
        int done = 0;
        MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
        return done != 0;
      },
      what);
}

std::size_t Communicator::receive(Message& into, const MPI_Status& status) const {
  int bytes = 0;
  MPI_Get_count(&status, MPI_BYTE, &bytes);
  auto& all = into.bytes();
  const std::size_t before = all.size();
  all.resize(before + static_cast<std::size_t>(bytes));
  MPI_Recv(all.data() + before, bytes, MPI_BYTE, status.MPI_SOURCE, status.MPI_TAG, comm_, MPI_STATUS_IGNORE);
  return static_cast<std::size_t>(bytes);
}

void Communicator::receive_one(std::vector<RankMessage>& received, std::size_t& count, const MPI_Status& status) {
  // The pieces of a message arrive in the order in which they were sent.
  const auto known = std::find_if(received.begin(), received.begin() + static_cast<std::ptrdiff_t>(count),
                                  [&](const RankMessage& message) { return message.rank == status.MPI_SOURCE; });
  const auto at = static_cast<std::size_t>(known - received.begin());
  if (at == count) {
    if (count == received.size()) received.emplace_back();
    received[count].rank = status.MPI_SOURCE;
    received[count++].content.clear();
  }
  receive(received[at].content, status);
}

/// Sends a message in pieces; the last piece of an expected message is shorter than the others, by which the receiver
/// recognises it.
void Communicator::send(RankMessage& message, int tag, bool expected) {
  const auto& bytes = message.content.bytes();
  for (std::size_t at = 0;; at += most_bytes) {
    if (at >= bytes.size() && !expected) return;
    const std::size_t count = std::min(most_bytes, bytes.size() - at);
    const auto piece = static_cast<int>(count);
    MPI_Request& request = requests_.emplace_back();
    if (expected)
      MPI_Isend(bytes.data() + at, piece, MPI_BYTE, message.rank, tag, comm_, &request);
    else
      MPI_Issend(bytes.data() + at, piece, MPI_BYTE, message.rank, tag, comm_, &request);
    if (count < most_bytes) return;
  }
}

void Communicator::exchange_expected(std::span<RankMessage> messages, std::vector<RankMessage>& received) {
  expected_round_ = (expected_round_ + 1) % rounds;
  const int tag = rounds + expected_round_;
  requests_.clear();
  received.resize(messages.size());
  waiting_.clear();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    send(messages[i], tag, true);
    received[i].rank = messages[i].rank;
    received[i].content.clear();
    waiting_.push_back(i);
  }
  const auto has_arrived = [&](std::size_t i) {
    int flag = 1;
    MPI_Status status;
    while (true) {
      MPI_Iprobe(received[i].rank, tag, comm_, &flag, &status);
      if (flag == 0) return false;
      if (receive(received[i].content, status) < most_bytes) return true;
    }
  };
  until(
      [&] {
        std::erase_if(waiting_, has_arrived);
        int done = 0;
        MPI_Testall(static_cast<int>(requests_.size()), requests_.data(), &done, MPI_STATUSES_IGNORE);
        return done != 0 && waiting_.empty();
      },
      "the exchange of bodies");
  std::sort(received.begin(), received.end(),
            [](const RankMessage& x, const RankMessage& y) { return x.rank < y.rank; });
}

void Communicator::exchange(std::span<RankMessage> messages, std::vector<RankMessage>& received) {
  round_ = (round_ + 1) % rounds;
  requests_.clear();
  for (RankMessage& message : messages) send(message, round_, false);
  std::size_t count = 0;
  MPI_Request barrier = MPI_REQUEST_NULL;
  bool at_barrier = false;
  until(
      [&] {
        int flag = 0;
        MPI_Status status;
        MPI_Iprobe(MPI_ANY_SOURCE, round_, comm_, &flag, &status);
        if (flag != 0) receive_one(received, count, status);
        int done = 0;
        if (!at_barrier) {
          MPI_Testall(static_cast<int>(requests_.size()), requests_.data(), &done, MPI_STATUSES_IGNORE);
          if (done == 0) return false;
          MPI_Ibarrier(comm_, &barrier);
          at_barrier = true;
          return false;
        }
        MPI_Test(&barrier, &done, MPI_STATUS_IGNORE);
        return done != 0;
      },
      "the exchange of bodies");
  received.resize(count);
  std::sort(received.begin(), received.end(),
            [](const RankMessage& x, const RankMessage& y) { return x.rank < y.rank; });
}

std::vector<RankMessage> Communicator::exchange(Outbox& outbox) {
  std::uint64_t unused = 0;
  return exchange(outbox, unused, unused);
}

std::vector<RankMessage> Communicator::exchange(Outbox& outbox, std::uint64_t& bytes, std::uint64_t& count) {
  std::vector<RankMessage> messages, received;
  for (int rank = 0; rank < ranks_; ++rank)
    if (Message& message = outbox.to(rank); rank != rank_ && !message.empty()) {
      bytes += message.size();
      ++count;
      messages.push_back({rank, std::move(message)});
    }
  if (ranks_ > 1) exchange(messages, received);
  if (!outbox.to(rank_).empty()) received.push_back({rank_, std::move(outbox.to(rank_))});
  return received;
}

void Communicator::post(Topic topic, Message message, int rank) {
  const auto& bytes = posted_.emplace_back(std::move(message)).bytes();
  if (bytes.size() > most_bytes)
    throw std::length_error("a message to another rank is longer than " + std::to_string(most_bytes >> 20) + " MiB");
  MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, rank, tag_of(topic), comm_, &posts_.emplace_back());
}

RankMessage Communicator::await(Topic topic, int rank) const {
  RankMessage message;
  MPI_Status status;
  until(
      [&] {
        int flag = 0;
        MPI_Iprobe(rank, tag_of(topic), comm_, &flag, &status);
        return flag != 0;
      },
      topic == Topic::colours ? "the colours of pairs" : "velocities");
  message.rank = status.MPI_SOURCE;
  receive(message.content, status);
  return message;
}

void Communicator::settle() {
  wait(posts_, "messages sent");
  posts_.clear();
  posted_.clear();
}

void Communicator::send(std::uint64_t value, int rank) const {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Isend(&value, 1, MPI_UINT64_T, rank, value_tag, comm_, &request);
  wait({&request, 1}, "a value sent");
}

std::uint64_t Communicator::receive(int rank) const {
  std::uint64_t value = 0;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Irecv(&value, 1, MPI_UINT64_T, rank, value_tag, comm_, &request);
  wait({&request, 1}, "a value from another rank");
  return value;
}

void Communicator::reduce(void* values, std::size_t count, MPI_Datatype type, MPI_Op op) const {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(MPI_IN_PLACE, values, static_cast<int>(count), type, op, comm_, &request);
  wait({&request, 1}, "a sum over ranks");
}

void Communicator::combine(Totals& totals) const {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallreduce(MPI_IN_PLACE, &totals, 1, totals_type_, totals_op_, comm_, &request);
  wait({&request, 1}, "a step's end");
}

void Communicator::sum(std::span<std::uint64_t> values) const {
  reduce(values.data(), values.size(), MPI_UINT64_T, MPI_SUM);
}
void Communicator::sum(std::span<double> values) const { reduce(values.data(), values.size(), MPI_DOUBLE, MPI_SUM); }
void Communicator::largest(std::span<double> values) const {
  reduce(values.data(), values.size(), MPI_DOUBLE, MPI_MAX);
}
void Communicator::largest(std::span<std::uint64_t> values) const {
  reduce(values.data(), values.size(), MPI_UINT64_T, MPI_MAX);
}

std::vector<Message> Communicator::to_all(Message& own) const {
  std::vector<std::uint64_t> sizes(static_cast<std::size_t>(ranks_));
  const std::uint64_t size = own.size();
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallgather(&size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, comm_, &request);
  wait({&request, 1}, "sizes of messages to all");
  std::vector<int> counts, places;
  std::uint64_t total = 0;
  for (const std::uint64_t bytes : sizes) {
    counts.push_back(static_cast<int>(bytes));
    places.push_back(static_cast<int>(total));
    total += bytes;
    if (total > std::uint64_t{INT_MAX}) throw std::length_error("messages to all ranks are longer than 2 GiB");
  }
  std::vector<std::byte> all(total);
  MPI_Iallgatherv(own.bytes().data(), counts[static_cast<std::size_t>(rank_)], MPI_BYTE, all.data(), counts.data(),
                  places.data(), MPI_BYTE, comm_, &request);
  wait({&request, 1}, "messages to all");
  std::vector<Message> out(sizes.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i].bytes().assign(all.begin() + places[i], all.begin() + places[i] + counts[i]);
  return out;
}

std::vector<std::string> Communicator::texts(const std::string& own) const {
  Message message;
  for (const char character : own) message.put(character);
  std::vector<std::string> out;
  for (Message& one : to_all(message)) {
    std::string& text = out.emplace_back();
    while (!one.done()) text += one.take<char>();
  }
  return out;
}

}  // namespace tandem::mpi
