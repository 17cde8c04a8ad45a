#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "base/place_hash.h"
#include "base/types.h"

namespace palpate {

/// Answers about some places in space, by the places' bits: for functions of them alone. What is kept saves time and
/// changes no answer.
template <std::size_t Size, class Answer>
class PlacesAsked {
 public:
  using Places = std::array<Vec3, Size>;  // m

  /// The answer if it is known, else null.
  const Answer* find(const Places& places) const {
    const auto found = answers_.find(places);
    return found == answers_.end() ? nullptr : &found->second;
  }
  void keep(const Places& places, const Answer& answer) {
    if (answers_.size() >= most) answers_.clear();
    answers_.emplace(places, answer);
  }

 private:
  static constexpr std::size_t most = 200'000;  // 30 MB
  struct Hash {
    std::size_t operator()(const Places& places) const {
      std::uint64_t hash = 0;
      for (const Vec3& x : places) hash = hashOf(x, hash);
      return hash;
    }
  };
  std::unordered_map<Places, Answer, Hash> answers_;
};

/// What was asked of one surface.
struct SurfaceMemory {
  PlacesAsked<4, bool> holds;  // whether a cell is inside (background_cells.h)
  PlacesAsked<3, double> gap;  // m, mean height of the surface above a facet (volume_fit.h)
};

}  // namespace palpate
