// Scenes shared between Python objects, and ids of bodies as integers.
#pragma once
#include <pybind11/numpy.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared_use.h"
#include "tandem/engine/scene.h"

namespace tandem::python {

using SharedScene = SharedUse<Scene>;

/// Ids are integers in Python, and arrays of them uint64: hashable, cheap, and 0 is no id.
using IdNumber = std::uint64_t;

inline IdNumber number(BodyId id) { return IdNumber{id.generation} << 32 | id.slot_plus_one; }
inline IdNumber number(ShapeId id) { return IdNumber{id.generation} << 32 | id.index_plus_one; }
inline BodyId body_id(IdNumber id) { return {static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32)}; }
inline ShapeId shape_id(IdNumber id) { return {static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32)}; }

/// Ids from an array (n,) of integers >= 0.
std::vector<BodyId> body_ids(const pybind11::handle& value, std::string_view what);
pybind11::array_t<IdNumber> to_array(std::span<const BodyId> ids);

Request request(std::string_view text);

}  // namespace tandem::python
