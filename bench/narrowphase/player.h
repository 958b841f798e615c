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
  std::function<std::size_t()> queries;  ///< that the last pass answered: all but those that would end the process
  std::function<void()> pass;
  std::function<Accuracy()> judge;  ///< of the last pass
};

/// One request on one workload, and who takes part.
struct Game {
  std::string kind, pair_class, request;
  std::size_t queries = 0;  ///< in all
  std::vector<Player> players;
  std::function<nlohmann::json(std::size_t)> record;  ///< of a query; null where it would be too long
};

/// Whoever has an answer to the request. The workload outlives the game.
Game make_game(const Workload& work, Request request);

/// Two tori of 1152 triangles each: "collide", "triangles", all pairs that intersect, and of those that are apart
/// "distance". The truth is every triangle of one against every one of the other; an error is the share of pairs that
/// are missing or too many, of distances how far off they are.
std::vector<Game> torus_games(std::string_view pair_class, std::size_t n);
inline constexpr std::string_view torus_kind = "torus-torus";

}  // namespace tandem::bench
