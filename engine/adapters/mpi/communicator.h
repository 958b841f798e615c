// Messages between ranks.
#pragma once
#include <mpi.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace tandem::mpi {

/// The bytes of a message, written and read as plain values one after the other.
class Message {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* const first = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  /// Reads a value. Throws std::out_of_range at the end of the message.
  template <class T>
  T take() {
    if (bytes_.size() - read_ < sizeof(T)) throw std::out_of_range("a message from another rank is cut off");
    T value;
    std::memcpy(&value, bytes_.data() + read_, sizeof(T));
    read_ += sizeof(T);
    return value;
  }
  void append(const Message& other) { bytes_.insert(bytes_.end(), other.bytes_.begin(), other.bytes_.end()); }
  bool done() const { return read_ == bytes_.size(); }
  bool empty() const { return bytes_.empty(); }
  std::size_t size() const { return bytes_.size(); }
  /// Empties the message and keeps its memory.
  void clear() {
    bytes_.clear();
    read_ = 0;
  }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t read_ = 0;
};

/// A message from or to one rank.
struct RankMessage {
  int rank = 0;
  Message content;
};

/// Messages to several ranks, this one included.
class Outbox {
 public:
  explicit Outbox(int ranks) : messages_(static_cast<std::size_t>(ranks)) {}
  Message& to(int rank) { return messages_[static_cast<std::size_t>(rank)]; }

 private:
  std::vector<Message> messages_;
};

/// A duplicate of a communicator, with the patterns of communication that the pipeline uses. Every wait is limited by
/// `patience`.
class Communicator {
 public:
  Communicator(MPI_Comm of, double patience);
  ~Communicator();
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  /// Sets the step that a failure's message names.
  void at_step(std::uint64_t step) { step_ = step; }
  std::uint64_t step() const { return step_; }

  /// Collective. Sends messages to a few ranks, not to itself, which do not know of them, and returns those that
  /// arrive, by rank (Hoefler, Siebert, Lumsdaine, "Scalable communication protocols for dynamic sparse data exchange",
  /// PPoPP 2010). The sent messages are unchanged; `received` keeps its memory from call to call.
  void exchange(std::span<RankMessage> messages, std::vector<RankMessage>& received);

  /// Collective. The same for the messages of an outbox, including those to itself.
  std::vector<RankMessage> exchange(Outbox& outbox);
  /// The same; also counts the bytes and messages sent to others.
  std::vector<RankMessage> exchange(Outbox& outbox, std::uint64_t& bytes, std::uint64_t& messages);

  /// Sends one message to each of some ranks, and receives one from each of the same, which must name this rank, too.
  void exchange_expected(std::span<RankMessage> messages, std::vector<RankMessage>& received);

  /// Values that combine() reduces over all ranks: the sums of the first, the maxima of the others, which are >= 0.
  struct Totals {
    std::array<std::uint64_t, 14> sums{};
    std::array<double, 6> largest{};
  };
  /// Collective.
  void combine(Totals& totals) const;

  /// Collective: sums, or maxima, over all ranks.
  void sum(std::span<std::uint64_t> values) const;
  void sum(std::span<double> values) const;
  void largest(std::span<double> values) const;
  void largest(std::span<std::uint64_t> values) const;

  /// Collective: the messages of all ranks to all ranks, by rank. Throws std::length_error beyond 2 GiB in all.
  std::vector<Message> to_all(Message& own) const;

  /// Collective: the texts of all ranks to all ranks, by rank.
  std::vector<std::string> texts(const std::string& own) const;

  /// The subjects of posted messages; each is awaited separately.
  enum class Topic { colours, velocities };
  /// Sends a message to a rank that awaits it; its buffer is in use until settle().
  void post(Topic topic, Message message, int rank);
  /// Receives the next message that a given rank, or any rank, has posted.
  RankMessage await(Topic topic, int rank) const;
  RankMessage await_any(Topic topic) const { return await(topic, MPI_ANY_SOURCE); }
  /// Completes the posted messages.
  void settle();

  /// Sends a value from one rank to another that expects it.
  void send(std::uint64_t value, int rank) const;
  std::uint64_t receive(int rank) const;

  /// Waits for the requests.
  void wait(std::span<MPI_Request> requests, const char* what) const;

  /// Prints one line on stderr that names rank, step and cause, then calls MPI_Abort.
  [[noreturn]] void abort(const std::string& cause) const;
  /// `abort` with the text of the current exception.
  [[noreturn]] void abort_for_exception() const;

 private:
  void reduce(void* values, std::size_t count, MPI_Datatype type, MPI_Op op) const;
  /// Calls done() until it returns true.
  template <class Done>
  void until(const Done& done, const char* what) const;
  void send(RankMessage& message, int tag, bool expected);
  /// Receives a piece; returns its number of bytes.
  std::size_t receive(Message& into, const MPI_Status& status) const;
  void receive_one(std::vector<RankMessage>& received, std::size_t& count, const MPI_Status& status);

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  double patience_;
  std::uint64_t step_ = 0;
  int round_ = 0, expected_round_ = 0;
  MPI_Datatype totals_type_ = MPI_DATATYPE_NULL;
  MPI_Op totals_op_ = MPI_OP_NULL;
  std::deque<Message> posted_;
  std::vector<MPI_Request> posts_;
  std::vector<std::size_t> waiting_;
  std::vector<MPI_Request> requests_;
};

}  // namespace tandem::mpi
