// Contacts and pairs as structured arrays.
#include "contact_arrays.h"

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "rows.h"

namespace tandem::python {

namespace py = pybind11;

// Rows of the arrays; the members' names are the arrays' fields.
struct PairContact {
  Triple point, normal;
  double depth;
  std::uint32_t feature;
};
struct StepContact {
  std::uint32_t a, b;
  Triple point, normal;
  double depth;
  std::uint32_t feature;
};
struct StepPair {
  std::uint32_t a, b;
  bool collide;
  double signed_distance, error_bound;
  std::uint32_t first_contact, contact_count;
  std::uint8_t status;
};

namespace {

// Describes the rows to numpy once, at the first use.
void describe_rows() {
  static const bool described = [] {
    PYBIND11_NUMPY_DTYPE(PairContact, point, normal, depth, feature);
    PYBIND11_NUMPY_DTYPE(StepContact, a, b, point, normal, depth, feature);
    PYBIND11_NUMPY_DTYPE(StepPair, a, b, collide, signed_distance, error_bound, first_contact, contact_count,
                         status);
    return true;
  }();
  static_cast<void>(described);
}

template <class Row>
py::array_t<Row> rows(std::size_t count) {
  describe_rows();
  return py::array_t<Row>(static_cast<py::ssize_t>(count));
}

}  // namespace

py::array contact_array(std::span<const Contact> contacts) {
  auto out = rows<PairContact>(contacts.size());
  PairContact* row = out.mutable_data();
  for (const Contact& c : contacts) *row++ = {numbers(c.point), numbers(c.normal), c.depth, c.feature};
  return out;
}

std::vector<Contact> contacts_in(const py::handle& value, std::string_view what) {
  describe_rows();
  const auto row = py::dtype::of<PairContact>();
  if (!py::isinstance<py::array>(value) || !py::cast<py::array>(value).dtype().equal(row))
    throw std::invalid_argument(std::string(what) + ": " + std::string(py::str(py::type::of(value))) +
                                ", allowed: an Answer, or an array as tandem.contacts gives it");
  const auto given = py::array_t<PairContact, py::array::c_style>::ensure(value);
  std::vector<Contact> out(static_cast<std::size_t>(given.size()));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const PairContact& c = given.data()[i];
    out[i] = {Vec3(c.point.data()), Vec3(c.normal.data()), c.depth, c.feature};
  }
  return out;
}

py::array contact_array(const ContactList& list) {
  auto out = rows<StepContact>(list.contacts.size());
  StepContact* row = out.mutable_data();
  for (const PairResult& pair : list.pairs)
    for (const Contact& c : list.of(pair))
      *row++ = {pair.a, pair.b, numbers(c.point), numbers(c.normal), c.depth, c.feature};
  return out;
}

py::array pair_array(const ContactList& list) {
  auto out = rows<StepPair>(list.pairs.size());
  StepPair* row = out.mutable_data();
  for (const PairResult& p : list.pairs)
    *row++ = {p.a, p.b, p.answer.collide, p.answer.signed_distance, p.answer.error_bound, p.first_contact,
              p.contact_count, static_cast<std::uint8_t>(p.answer.status)};
  return out;
}

}  // namespace tandem::python
