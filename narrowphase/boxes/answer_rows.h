// Rows of contacts and answers, as vector kernels write them.
#pragma once
#include <cstddef>
#include <cstring>
#include <vector>

#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Contacts found by kernels, one a pair: the numbers of a `Contact` in their order, the feature by its bits, in two
/// halves that are stored several pairs at a time (`store_in_turn`) and copied as they are.
template <std::size_t most>
struct ContactRows {
  alignas(64) double first[most][4], second[most][4];

  Vec3 normal(std::size_t pair) const { return {first[pair][3], second[pair][0], second[pair][1]}; }
  void copy(std::size_t pair, Contact& contact) const {
    static_assert(offsetof(Contact, feature) == 7 * sizeof(double) && sizeof(Contact) == 8 * sizeof(double));
    double* const to = static_cast<double*>(static_cast<void*>(&contact));
    std::memcpy(to, first[pair], sizeof first[pair]);
    std::memcpy(to + 4, second[pair], sizeof second[pair]);
  }
};

/// The numbers of a `PairAnswer` from its distance on, stored likewise; the normal is that of `contact`.
template <std::size_t most>
struct AnswerRows {
  alignas(64) double first[most][4], second[most][4];  ///< distance, point on A; point on B, the normal's first

  void copy(std::size_t pair, const ContactRows<most>& contact, PairAnswer& answer) const {
    static_assert(offsetof(PairAnswer, normal) == offsetof(PairAnswer, signed_distance) + 7 * sizeof(double));
    char* const to = static_cast<char*>(static_cast<void*>(&answer)) + offsetof(PairAnswer, signed_distance);
    std::memcpy(to, first[pair], sizeof first[pair]);
    std::memcpy(to + sizeof first[pair], second[pair], sizeof second[pair]);
    std::memcpy(to + 8 * sizeof(double), contact.second[pair], 2 * sizeof(double));
  }
};

}  // namespace tandem
