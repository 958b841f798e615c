// Contacts as numpy arrays.
#pragma once
#include <pybind11/numpy.h>

#include <span>
#include <string_view>
#include <vector>

#include "tandem/flowgraph/contact_list.h"
#include "tandem/narrowphase/answer.h"

namespace tandem::python {

/// Structured arrays that own their data. The contacts of a pair: point, normal, depth, feature.
pybind11::array contact_array(std::span<const Contact> contacts);
/// The contacts in such an array. Throws std::invalid_argument "WHAT: ..." for anything else.
std::vector<Contact> contacts_in(const pybind11::handle& value, std::string_view what);
/// The contacts of a step: a, b (body indices), point, normal, depth, feature.
pybind11::array contact_array(const ContactList& list);
/// The pairs of a step: a, b, collide, signed_distance, error_bound, first_contact, contact_count.
pybind11::array pair_array(const ContactList& list);

}  // namespace tandem::python
