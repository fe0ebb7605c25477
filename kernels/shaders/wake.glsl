// The lists of tiles that sweeps visit, and which tiles the next sweep has to visit: those that see a change of this one.
// The includer supplies, after tile_class.inc, storage buffers and what the host says:
//
//   uint tiles[]        as tile_class.inc lays them out
//   uvec4 lengths[]     of lists, w: number of tiles, xyz: work groups to sweep them with, as indirect dispatches read
//   uvec4 appended_lengths[]  the same of the lists that are made
//   int tiles_across, tile_count
//   int list       the set of lists to sweep
//   int next_list  the set that changes are put on
//   int stamp      of this sweep, > 0, another one for each since the stamps were cleared
//
// Nothing waits for anything: atomicExchange decides who appends a tile, once.

void append_tile(uint tile, uint its_class) {
  uint place = atomicAdd(appended_lengths[its_class].w, 1u);
  tiles[list_begin(uint(next_list), its_class, uint(tile_count)) + place] = tile;
  if (place < most_groups_across) {
    atomicMax(appended_lengths[its_class].x, place + 1u);
  }
  if (place % most_groups_across == 0u) {
    atomicAdd(appended_lengths[its_class].y, 1u);
    appended_lengths[its_class].z = 1u;
  }
}

// The tile that a work group sweeps; -1: none.
int listed_tile(uvec3 group, uint tile_class) {
  uint place = group.y * most_groups_across + group.x;
  return place < lengths[tile_class].w
             ? int(tiles[list_begin(uint(list), tile_class, uint(tile_count)) + place])
             : -1;
}

// Puts on the next lists what sweep_tile() of tile.glsl said, of an image.
void wake(ivec2 tile, int seen_from) {
  ivec2 grid = ivec2(tiles_across, tile_count / tiles_across);
  for (; seen_from != 0; seen_from &= seen_from - 1) {
    int bit = findLSB(seen_from);
    ivec2 other = tile + ivec2(bit % 3 - 1, bit / 3 - 1);
    if (all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, grid))) {
      uint woken = uint(other.y * tiles_across + other.x);
      if (atomicExchange(tiles[stamps_section * uint(tile_count) + woken], uint(stamp)) != uint(stamp)) {
        append_tile(woken, tiles[classes_section * uint(tile_count) + woken]);
      }
    }
  }
}
