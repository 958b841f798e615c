// Contestants and the games that they take part in: one request on one workload.
#pragma once
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "accuracy.h"

namespace tandem::bench {

/// A contestant with the answers of its last pass.
struct Player {
  std::string name;
  /// The number that the last pass answered: all but those that would end the process.
  std::function<std::size_t()> queries;
  std::function<void()> pass;
  std::function<Accuracy()> judge;  ///< accuracy of the last pass
};

/// One request on one workload, with its contestants.
struct Game {
  std::string kind, pair_class, request;
  std::size_t queries = 0;  ///< queries in all
  std::vector<Player> players;
  std::function<nlohmann::json(std::size_t)> record;  ///< the record of a query; null where it would be too long
};

/// The game with all contestants that can answer the request. The workload outlives it.
Game make_game(const Workload& work, Request request);

/// Two tori of 1152 triangles each: "collide"; "triangles", all pairs that intersect; and for separated pairs
/// "distance". The reference tests every triangle of one against every one of the other. The error is the fraction of
/// pairs missing or in excess, and for distances the relative error.
std::vector<Game> torus_games(std::string_view pair_class, std::size_t n);
inline constexpr std::string_view torus_kind = "torus-torus";

}  // namespace tandem::bench
