#include "backends/pieces/sharing.hpp"

#include <algorithm>
#include <utility>

namespace hdmbench {

namespace {

/// How often an axis of the image was halved down to a level. Where it has so few sites that one cannot tell
/// it is not cut, and nobody asks.
int halvings(std::span<const Extent> levels, int level, std::size_t axis) {
  int count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(level); ++i) {
    count += levels[i].sides()[axis] != levels[i + 1].sides()[axis] ? 1 : 0;
  }
  return count;
}

/// Coarse site i is fine site 2^halvings i; the end of the image is the end of its levels.
Box on_level(const Box& part, std::span<const Extent> levels, int level) {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int halved = halvings(levels, level, axis);
    box.first[axis] = part.first[axis] >> halved;
    box.end[axis] = part.end[axis] == levels.front().sides()[axis]
                        ? levels[static_cast<std::size_t>(level)].sides()[axis]
                        : ((part.end[axis] - 1) >> halved) + 1;
  }
  return box;
}

/// Returns the cut of the image on another level. Along an axis that was halved less often than others the
/// halo is wider than Cut::halo says: what is right for so many sites is right there, too.
LevelShare on_level(const Cut& image_cut, std::span<const Extent> levels, int level, int places) {
  Cut cut = image_cut;
  cut.halo >>= level;
  for (Piece& piece : cut.pieces) {
    piece = {.owned = on_level(piece.owned, levels, level), .loaded = on_level(piece.loaded, levels, level)};
  }
  return share_of(std::move(cut), places);
}

/// Cut at multiples of 2^cut_levels sites, a volume at twice as many, so that the level below has two slices
/// of each piece; no pieces where that cannot be. A piece is loaded with one site more than a multiple, so
/// that its last cells are whole on all levels.
Cut elastic_cut(Extent image, int count, int cut_levels, int halo) {
  const int granule = 1 << cut_levels;
  Cut cut = cut_image(image, count, halo * granule / 2, image.axes() == 3 ? 2 * granule : granule);
  for (Piece& piece : cut.pieces) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      piece.loaded.end[axis] += piece.loaded.end[axis] < image.sides()[axis] ? 1 : 0;
    }
  }
  return cut;
}

/// Copies `part` of all arrays.
void copy_arrays(const Box& part, int arrays, std::span<const float> from, const Box& from_sites,
                 std::span<float> to, const Box& to_sites) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(arrays); ++i) {
    const auto array = [i](auto values, const Box& sites) {
      return values.subspan(i * sites.extent().sites(), sites.extent().sites());
    };
    copy(part, array(from, from_sites), from_sites, array(to, to_sites), to_sites);
  }
}

} // namespace

LevelShare share_of(Cut cut, int places) {
  LevelShare share{.cut = std::move(cut), .owned = {}, .loaded = {}};
  share.owned.resize(static_cast<std::size_t>(places));
  share.loaded.resize(share.owned.size());
  for (std::size_t i = 0; i < share.cut.pieces.size(); ++i) {
    share.owned[i] = share.cut.pieces[i].owned;
    share.loaded[i] = share.cut.pieces[i].loaded;
  }
  return share;
}

PieceRange own_pieces(const Exchange& exchange, std::size_t pieces) {
  const auto rank = static_cast<std::size_t>(exchange.rank());
  return exchange.size() == 1 ? PieceRange{0, pieces} : PieceRange{rank, rank + 1};
}

std::vector<Box> all_on_first(Extent extent, std::size_t pieces) {
  std::vector<Box> held(pieces);
  held.front() = all_of(extent);
  return held;
}

LevelShare Sharing::level(Extent extent, bool in_rows) const {
  constexpr std::size_t usual = std::size_t{1} << 14;
  const std::size_t fewest = fewest_sites > 0 ? fewest_sites : usual;
  Cut cut;
  for (auto count = static_cast<int>(
           std::clamp<std::size_t>(extent.sites() / fewest, 1, static_cast<std::size_t>(pieces)));
       cut.pieces.empty(); --count) {
    cut = in_rows ? cut_rows(extent, count, halo) : cut_image(extent, count, halo);
  }
  return share_of(std::move(cut), ranks);
}

ElasticShare Sharing::elastic(std::vector<Extent> levels) const {
  constexpr std::size_t usual = std::size_t{1} << 12;
  constexpr int usual_halo = 4;
  const std::size_t fewest = fewest_sites > 0 ? fewest_sites : usual;
  ElasticShare share{.levels = std::move(levels), .shares = {}};
  const Extent image = share.levels.front();
  for (int count = pieces; count > 1; --count) {
    for (int cut_levels = static_cast<int>(share.levels.size()) - 1; cut_levels > 0; --cut_levels) {
      const Extent coarsest_cut = share.levels[static_cast<std::size_t>(cut_levels) - 1];
      if (coarsest_cut.sites() / fewest < static_cast<std::size_t>(count)) {
        continue;
      }
      const Cut cut = elastic_cut(image, count, cut_levels, halo > 0 ? halo : usual_halo);
      for (int level = 0; level <= cut_levels && !cut.pieces.empty(); ++level) {
        share.shares.push_back(on_level(cut, share.levels, level, ranks));
      }
      if (!share.shares.empty()) {
        return share;
      }
    }
  }
  share.shares.push_back(share_of(cut_image(image, 1), ranks));
  return share;
}

std::vector<std::vector<float>> redistribute(Exchange& exchange, Purpose purpose, std::span<const Box> held,
                                             std::span<const Box> wanted,
                                             std::span<const std::vector<float>> own, int arrays) {
  const PieceRange here = own_pieces(exchange, held.size());
  const auto room = [arrays](const Box& sites) {
    return std::vector<float>(static_cast<std::size_t>(arrays) * sites.extent().sites());
  };
  const std::vector<Transfer> ways = transfers(held, wanted);
  std::vector<Message> leaving;
  for (const Transfer& way : ways) {
    if (way.from >= here.first && way.from < here.end) {
      Message& message = leaving.emplace_back(Message{.way = way, .values = room(way.sites)});
      copy_arrays(way.sites, arrays, own[way.from - here.first], held[way.from], message.values, way.sites);
    }
  }
  std::vector<std::vector<float>> result;
  for (std::size_t piece = here.first; piece < here.end; ++piece) {
    result.push_back(room(wanted[piece]));
    if (const Box stays = intersection(held[piece], wanted[piece]); stays.extent().sites() > 0) {
      copy_arrays(stays, arrays, own[piece - here.first], held[piece], result.back(), wanted[piece]);
    }
  }
  for (const Message& message : exchange.exchange(ways, std::move(leaving), arrays, purpose)) {
    const std::size_t to = message.way.to;
    copy_arrays(message.way.sites, arrays, message.values, message.way.sites, result[to - here.first],
                wanted[to]);
  }
  return result;
}

std::vector<VectorField> redistribute(Exchange& exchange, Purpose purpose, std::span<const Box> held,
                                      std::span<const Box> wanted, std::span<const VectorField> own) {
  std::size_t axes = 2;
  for (const std::span<const Box>& boxes : {held, wanted}) { // a piece without sites does not know
    for (const Box& box : boxes) {
      axes = std::max(axes, box.extent().axes());
    }
  }
  std::vector<std::vector<float>> all;
  for (const VectorField& field : own) {
    std::vector<float>& values = all.emplace_back();
    for (std::size_t axis = 0; axis < axes; ++axis) {
      values.insert(values.end(), field[axis].begin(), field[axis].end());
    }
  }
  std::size_t piece = own_pieces(exchange, held.size()).first;
  std::vector<VectorField> fields;
  for (const std::vector<float>& values :
       redistribute(exchange, purpose, held, wanted, all, static_cast<int>(axes))) {
    VectorField& field = fields.emplace_back();
    field.extent = wanted[piece++].extent();
    auto from = values.begin();
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const auto end = from + static_cast<std::ptrdiff_t>(field.extent.sites());
      field[axis].assign(from, end);
      from = end;
    }
  }
  return fields;
}

VectorField whole_of(Exchange& exchange, std::span<const Box> held, Extent extent,
                     std::span<const VectorField> own) {
  const std::vector<Box> wanted = exchange.size() == 1 ? all_on_first(extent, held.size())
                                                       : std::vector<Box>(held.size(), all_of(extent));
  return std::move(redistribute(exchange, Purpose::results, held, wanted, own).front());
}

} // namespace hdmbench
