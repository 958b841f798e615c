#pragma once
#include <utility>

#include "communicator.h"
#include "pipeline/kept_contacts.h"
#include "tandem/mpi/contact_events.h"

namespace tandem::mpi {

/// What is kept of a pair, from the rank that reported it in the last step to the one that does in this one.
void write_kept(Message& message, const IdPair& ids, const KeptRecord& record);
/// In the record the pair is not set.
std::pair<IdPair, KeptRecord> take_kept(Message& message);

}  // namespace tandem::mpi
