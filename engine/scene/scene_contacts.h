// Checks that a list of contacts belongs to a scene.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// Throws std::invalid_argument that names `what`, if the list names a body that is not in the scene, or contacts that
/// it does not have. A removed body whose index another body has taken is not detected. O(pairs).
inline void require_contacts_of(const Scene& scene, const ContactList& contacts, std::string_view what) {
  const auto refuse = [&](const std::string& found) {
    throw std::invalid_argument(std::string(what) + ": " + found +
                                ", allowed: those of a step of this scene, from which no body was removed since");
  };
  for (const PairResult& pair : contacts.pairs) {
    for (const std::uint32_t body : {pair.a, pair.b})
      if (body >= scene.indices() || !scene.alive(body))
        refuse("contacts of body " + std::to_string(body) + ", which does not exist");
    if (std::uint64_t{pair.first_contact} + pair.contact_count > contacts.contacts.size())
      refuse("a pair with contacts that the list does not have");
  }
}

}  // namespace tandem
