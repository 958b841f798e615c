// Messages with kept answers.
#pragma once
#include <utility>

#include "communicator.h"
#include "pipeline/kept_contacts.h"
#include "tandem/mpi/contact_events.h"

namespace tandem::mpi {

/// Writes the kept answer of a pair, from the rank that reported it in the last step for the one that now does.
void write_kept(Message& message, const IdPair& ids, const KeptRecord& record);
/// Reads a kept answer; the pair in the record is not set.
std::pair<IdPair, KeptRecord> take_kept(Message& message);

}  // namespace tandem::mpi
