// Lists that a batch appends its answers to.
#pragma once
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Lends lists to a batch for as long as the object lives: what it is narrowed to is appended to them.
class LentLists {
 public:
  LentLists(Batch& batch, std::vector<PairResult>& results, std::vector<Contact>& contacts)
      : batch_(batch), results_(results), contacts_(contacts) {
    exchange();
  }
  ~LentLists() { exchange(); }
  LentLists(const LentLists&) = delete;
  LentLists& operator=(const LentLists&) = delete;

 private:
  void exchange() {
    batch_.results.swap(results_);
    batch_.contacts.swap(contacts_);
  }
  Batch& batch_;
  std::vector<PairResult>& results_;
  std::vector<Contact>& contacts_;
};

}  // namespace tandem
