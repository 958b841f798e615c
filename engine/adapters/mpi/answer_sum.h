// The hash of answers that does not depend on how pairs are distributed over ranks.
#pragma once
#include <cstdint>
#include <span>

#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// The hash of a pair and its contacts; hash(GatheredContacts) is the sum of these.
std::uint64_t hash_of_pair(GlobalId a, GlobalId b, const PairAnswer& answer, std::span<const Contact> contacts);

}  // namespace tandem::mpi
