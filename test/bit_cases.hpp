#pragma once

#include "backends/backend.hpp"
#include "test/random_level.hpp"

#include <string>
#include <string_view>
#include <vector>

/// The table of what every backend must compute with scalar's bits, however it lays out its work. To add a
/// case, add it to a group in bit_cases.cpp: all backends then do it in all their ways.
namespace hdmbench::test {

/// A level that is swept, or a pyramid over it that is solved in one piece.
struct BitCase {
  std::string name; ///< says how it is made
  Problem problem;
  /// Numbers of sweeps, after each of which field and count are compared. Then `again` is written, without a
  /// load, and the first number of sweeps but 0 follows.
  std::vector<int> calls{1, 1, 2, 5};
  std::optional<VectorField> again{}; ///< none: problem.start
  /// Not empty: these are solved twice instead, from the null field.
  std::vector<PyramidLevel> levels{};
  Alignment alignment = Alignment::corner;
};

/// What the groups of cases are about.
enum class Group {
  sizes,      ///< 1 x N, odd and even sides, sides at the edges of tiles, every remainder of a vector
  rules,      ///< every rule with every order of sites, of the thesis's energy and of a coupled one
  candidates, ///< every number of candidates, and exact ties between them
  tiles,      ///< one site unlike the others in a tile, in its rim and beside it
  waking,     ///< fields at rest in which something begins to move, and fronts that run through them
  pyramids,   ///< all levels in one piece
  volumes,    ///< every rule with every order of sites, all kinds of tiles, pyramids
  layouts,    ///< a few that show how an image is cut into tiles or among threads
};
inline constexpr std::array<std::string_view, 8> group_names{"sizes",  "rules",    "candidates", "tiles",
                                                             "waking", "pyramids", "volumes",    "layouts"};
inline constexpr std::array all_groups{Group::sizes,  Group::rules,    Group::candidates, Group::tiles,
                                       Group::waking, Group::pyramids, Group::volumes,    Group::layouts};
[[nodiscard]] std::vector<BitCase> cases_of(Group group);

/// A random level, whose name says how it is made.
[[nodiscard]] BitCase random_bit_case(Extent extent, Texture texture, std::uint64_t seed,
                                      std::optional<StepSet> steps = {}, Rule rule = Rule::steps,
                                      Update update = Update::simultaneous);

/// What a session is seen to have computed.
struct State {
  VectorField field;
  std::int64_t changed = 0; ///< sites that the last sweep changed
};

/// The cases and what scalar makes of them, sweep by sweep.
class ExpectedBits {
public:
  explicit ExpectedBits(std::vector<BitCase> cases);

  /// Lets the session do all cases one after another, so that each also meets what the one before has left.
  /// Says which differ from scalar and where, a line each and not more than three; empty where none does.
  /// TooLarge passes where `refused` is given: such cases are counted there.
  [[nodiscard]] std::string differences(Session& session, int* refused = nullptr) const;
  [[nodiscard]] std::size_t count() const { return cases_.size(); }

private:
  std::vector<BitCase> cases_;
  std::vector<std::vector<State>> expected_; ///< of each case
};

/// A way of a backend to compute: threads, tiles, work that is left out.
struct Way {
  std::string name;
  SessionOptions options;
};

/// The ways in which a backend is to do a group: dense and active, by one thread and by several, and of
/// layouts by every other number of threads; none where there is one only.
[[nodiscard]] std::vector<Way> ways_of(const Backend& backend, Group group);

} // namespace hdmbench::test
